// The sources file: what is read, on every rank, and how mistakes are told.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "generate/sources_file.hpp"
#include "tests/generate/expect_error.hpp"
#include "tests/support/world.hpp"

namespace skein {
namespace {

using test::expect_error;
using test::world;

const std::string kGood = R"(size_max = 3
[[point]]
at = [1, 2.5, -3]
spacing = 0.1
r1 = 0
r2 = 1
[[line]]
from = [0, 0, 0]
to = [1, 0, 0]
spacing = 0.2
r1 = 0.5
r2 = 1.5
[[triangle]]
a = [0, 0, 0]
b = [1, 0, 0]
c = [0, 1, 0]
spacing = 0.3
r1 = 0.25
r2 = 4
[[line]]
from = [0, 0, 1]
to = [1, 0, 1]
spacing = 1e-3
r1 = 0.5
r2 = 1.5
)";

std::string with(std::string text, const std::string& old, const std::string& now) {
  return text.replace(text.find(old), old.size(), now);
}

TEST(SourcesFile, IsTheSameOnEveryRank) {
  const std::string path = testing::TempDir() + "skein_sources_" + std::to_string(world().size()) + ".toml";
  if (world().is_root()) std::ofstream(path) << kGood;
  const SpacingField f = read_sources(world(), path);
  EXPECT_EQ(f.size_max, 3);
  ASSERT_EQ(f.sources.size(), 4U);
  int corners = 0;
  for (const Source& s : f.sources) corners += s.corners;
  EXPECT_EQ(corners, 1 + 2 + 3 + 2);
  for (const Source& s : f.sources) {
    if (s.corners == 1) {
      EXPECT_EQ(SpacingField{{s}}.at({1, 2.5, -3}), 0.1);
    }
    if (s.corners == 3) {
      EXPECT_NEAR(SpacingField{{s}}.at({0.1, 0.1, -4}), 0.6, 1e-12);
    }
  }
  EXPECT_DOUBLE_EQ(f.at({0.5, 0, 1.1}), 1e-3);
  EXPECT_EQ(f.at({100, 100, 100}), 3);
}

TEST(SourcesFile, MissingFileIsAnErrorOnAllRanks) {
  expect_error([] { read_sources(world(), "/nowhere/sources.toml"); }, ExitCode::kInput, {"/nowhere/sources.toml"});
}

TEST(SourcesFile, ExamplesAreValid) {
  for (const std::string name : {"sources/example.toml", "wingbody/sources.toml"}) {
    const SpacingField f = read_sources(world(), std::string(SKEIN_EXAMPLES) + "/" + name);
    EXPECT_GE(f.sources.size(), 3U) << name;
    EXPECT_LT(f.size_max, 1e300) << name;
  }
}

TEST(SourcesFile, MayBeEmpty) {
  const SpacingField f = parse_sources("", "x.toml");
  EXPECT_TRUE(f.sources.empty());
  EXPECT_EQ(f.at({}), SpacingField{}.size_max);
}

TEST(SourcesFile, MistakesAreToldWithFileLineAndKey) {
  const auto mistake = [](const std::string& old, const std::string& now, std::initializer_list<std::string> words) {
    expect_error([&] { parse_sources(with(kGood, old, now), "s.toml"); }, ExitCode::kInput, words);
  };
  mistake("size_max = 3", "size_max = 0", {"s.toml:1:", "'size_max'", "greater than 0"});
  mistake("size_max = 3", "size_max = nan", {"s.toml:1:", "'size_max'", "finite"});
  mistake("size_max = 3", "largest = 3", {"s.toml:1:", "'largest'"});
  mistake("at = [1, 2.5, -3]", "at = [1, 2.5]", {"s.toml:3:", "'at'", "[x, y, z]"});
  mistake("at = [1, 2.5, -3]", "at = [1, 2.5, 'a']", {"s.toml:3:", "'at'", "number"});
  mistake("at = [1, 2.5, -3]\n", "", {"s.toml:2:", "'at'", "[[point]]"});
  mistake("spacing = 0.2", "spacing = -1", {"s.toml:10:", "'spacing'", "greater than 0"});
  mistake("spacing = 0.2", "spacing = true", {"s.toml:10:", "'spacing'", "number"});
  mistake("r1 = 0.5", "r1 = -0.5", {"s.toml:11:", "'r1'"});
  mistake("r2 = 1.5", "r2 = 0.5", {"s.toml:12:", "'r2'", "'r1'"});
  mistake("r2 = 4", "r3 = 4", {"s.toml:19:", "'r3'", "[[triangle]]"});
  mistake("[[triangle]]", "[triangle]", {"s.toml:13:", "[[triangle]]"});
  mistake("[[triangle]]", "[[triangle", {"s.toml:13:"});
  mistake("c = [0, 1, 0]", "c = ", {"s.toml:16:"});
}

}  // namespace
}  // namespace skein
