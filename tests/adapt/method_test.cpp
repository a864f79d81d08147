// Methods as files: what is printed is read back, and what is wrong is told with its line.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <type_traits>

#include "adapt/method_file.hpp"
#include "kernel/method_numbers.hpp"

namespace skein::test {
namespace {

std::map<std::string, double> numbers_of(const Method& m) {
  std::map<std::string, double> out;
  for_each_number(m, [&](std::string_view name, const auto& number, double least, double most, std::string_view what) {
    EXPECT_TRUE(out.emplace(name, number).second) << name << " is there twice";
    EXPECT_LE(least, number) << name;
    EXPECT_GE(most, number) << name;
    EXPECT_FALSE(what.empty()) << name;
  });
  return out;
}

std::string refusal(const std::string& text) {
  try {
    parse_method(text, "m.toml");
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

TEST(Method, ListNamesEveryNumber) {
  // What the list forgets keeps the pattern; padding is never a whole aligned word.
  static_assert(std::is_trivially_copyable_v<Method>);
  std::array<unsigned char, sizeof(Method)> bytes;
  bytes.fill(0xab);
  Method m;
  std::memcpy(static_cast<void*>(&m), bytes.data(), bytes.size());
  m.points = PointCreation::kEdges;
  for_each_number(m, [](std::string_view, auto& number, double, double, std::string_view) { number = 0; });
  std::memcpy(bytes.data(), &m, bytes.size());
  for (std::size_t i = 0; i < bytes.size(); i += 8) {
    EXPECT_NE(std::count(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                         bytes.begin() + static_cast<std::ptrdiff_t>(i + 8), 0xab),
              8)
        << "a number at byte " << i << " of Method is not in the list";
  }
}

TEST(Method, EveryPresetComesBackFromItsFile) {
  for (const Preset& p : presets()) {
    const Method m = parse_method(method_to_toml(p.method, p.name), "m.toml");
    EXPECT_EQ(numbers_of(m), numbers_of(p.method)) << p.name;
    EXPECT_EQ(m.points, p.method.points);
    EXPECT_EQ(m.smoothing, p.method.smoothing);
  }
}

TEST(Method, EveryNumberCanBeSetAlone) {
  for_each_number(Method{}, [](std::string_view name, const auto& number, double least, double most, std::string_view) {
    constexpr bool kWhole = std::is_same_v<std::remove_cvref_t<decltype(number)>, int>;
    const double other =
        kWhole ? (number + 1 <= most ? number + 1 : number - 1) : 0.5 * (number + (number < most ? most : least));
    const std::size_t dot = name.find('.');
    auto expected = numbers_of(Method{});
    expected[std::string(name)] = other;
    const std::string text = fmt::format("[{}]\n{} = {}\n", name.substr(0, dot), name.substr(dot + 1), other);
    EXPECT_EQ(numbers_of(parse_method(text, "m.toml")), expected) << text;
  });
  EXPECT_EQ(parse_method("[swap]\ngain = 1.25\n", "m.toml").swap.gain, 1.25);
  EXPECT_EQ(parse_method("preset = \"chapter\"\n[swap]\ngain = 1.25\n", "m.toml").points, PointCreation::kCentroids);
}

TEST(Method, WrongFilesAreRefusedWithTheirLine) {
  EXPECT_EQ(refusal("[swap]\n\ngian = 1.2\n"), "m.toml:3: there is no 'swap.gian'; is 'swap.gain' meant?");
  EXPECT_EQ(refusal("[swap]\ngain = 0.5\n"), "m.toml:2: 'swap.gain' is 0.5; it must be from 1 to 10");
  EXPECT_EQ(refusal("[main]\nmost_turns = 2.5\n"), "m.toml:2: 'main.most_turns' must be a whole number");
  EXPECT_EQ(refusal("[swap]\ngain = \"much\"\n"), "m.toml:2: 'swap.gain' must be a finite number");
  EXPECT_EQ(refusal("points = \"corners\"\n"), "m.toml:1: 'points' must be \"edges\" or \"centroids\"");
  EXPECT_NE(refusal("preset = \"best\"\n").find("there are: default, chapter, quick"), std::string::npos);
  EXPECT_EQ(refusal("swap = 1\n").substr(0, 9), "m.toml:1:");
  EXPECT_EQ(refusal("[swap\n").substr(0, 9), "m.toml:1:");
}

}  // namespace
}  // namespace skein::test
