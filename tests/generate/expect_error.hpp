// EXPECT_ERROR: a statement throws skein::Error with this exit code and all of these words in its line.
#pragma once
#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>
#include <string>

#include "base/error.hpp"

namespace skein::test {

inline void expect_error(const std::function<void()>& work, ExitCode code, std::initializer_list<std::string> words) {
  try {
    work();
    ADD_FAILURE() << "no error";
  } catch (const Error& e) {
    const std::string line = e.what();
    EXPECT_EQ(e.code(), code) << line;
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    for (const std::string& word : words) EXPECT_NE(line.find(word), std::string::npos) << line << " lacks " << word;
  }
}

}  // namespace skein::test
