// One OptionSet through flags, config files, --print-config, JSON and Markdown.
#include "apps/commands/option_binding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "apps/run/run_output.h"
#include "core/support/config.h"
#include "core/support/error.h"

namespace burin {
namespace {

using testing::HasSubstr;

enum class Kind { kUmbrella, kBilaplacian };
Choices<Kind> ChoicesOf(Kind) {
  return {{Kind::kUmbrella, "umbrella"}, {Kind::kBilaplacian, "bilaplacian"}};
}

struct SampleOptions {
  bool enabled = true;
  int count = 3;
  double weight = 0.1;
  Kind kind = Kind::kUmbrella;
  std::string label = "a \"quoted\" \\ back, tab\t and caf\xC3\xA9 # no comment";
  double tiny = 5e-324;
  double third = 1.0 / 3.0;

  OptionSet Describe() {
    OptionSet set;
    set.Add("smooth.enabled", &enabled, "use the term");
    set.Add("level.count", &count, "pyramid levels", 1, 10);
    set.Add("smooth.weight", &weight, "factor of the term", 0, 1e6);
    set.Add("smooth.kind", &kind, "operator");
    set.Add("label", &label, "name of the run | free text");
    set.Add("solver.tiny", &tiny, "a denormal", -1, 1);
    set.Add("solver.third", &third, "a value with 16 digits", -1e300, 1e300);
    return set;
  }
};

// The message of the InputError that the config text causes; empty when it is accepted.
std::string ConfigError(const std::string& text) {
  SampleOptions options;
  OptionSet set = options.Describe();
  try {
    ParseConfig(text, "c.toml", &set);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& text)
      : path_(std::filesystem::path(testing::TempDir()) / name) {
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

TEST(Option, AChoiceIsSetByItsNameOnly) {
  SampleOptions options;
  OptionSet set = options.Describe();
  Option* kind = set.Find("smooth.kind");
  std::string error;
  EXPECT_TRUE(kind->Set("bilaplacian", &error));
  EXPECT_EQ(options.kind, Kind::kBilaplacian);
  EXPECT_EQ(kind->Text(), "bilaplacian");
  for (const char* wrong : {"cotan", "", "1", "Umbrella", "umbrella "}) {
    EXPECT_FALSE(kind->Set(wrong, &error));
    EXPECT_EQ(error,
              std::string("smooth.kind = ") + wrong + ": must be one of umbrella, bilaplacian");
    EXPECT_EQ(options.kind, Kind::kBilaplacian);
  }
}

// Choices that only the running program knows stay a string.
TEST(Option, AStringMayHaveChoicesToo) {
  std::string solver = "auto";
  OptionSet set;
  set.Add("solver", &solver, "minimiser", {"auto", "mine"});
  std::string error;
  EXPECT_TRUE(set.Find("solver")->Set("mine", &error));
  EXPECT_EQ(solver, "mine");
  EXPECT_FALSE(set.Find("solver")->Set("yours", &error));
  EXPECT_EQ(error, "solver = yours: must be one of auto, mine");
}

TEST(OptionDeathTest, AValueWithoutAName) {
  EXPECT_DEATH(NameOf(static_cast<Kind>(7)), "no name for value 7");
}

void Parse(SampleOptions* options, std::vector<std::string> arguments) {
  CLI::App app;
  OptionSet set = options->Describe();
  BindOptions(&set, &app);
  std::reverse(arguments.begin(), arguments.end());  // what CLI11's vector overload takes
  app.parse(arguments);
}

TEST(Config, EveryValueReadsBackIdentically) {
  SampleOptions written;
  written.enabled = false;
  written.count = 7;
  written.weight = 0.1 + 0.2;
  written.third = -1e22;
  written.kind = Kind::kBilaplacian;
  written.label += "\x01\x7F\r\n";
  const std::string text = ConfigText(written.Describe());
  SampleOptions read;
  OptionSet set = read.Describe();
  ParseConfig(text, "c.toml", &set);
  EXPECT_EQ(read.enabled, written.enabled);
  EXPECT_EQ(read.count, written.count);
  EXPECT_EQ(read.weight, written.weight);
  EXPECT_EQ(read.kind, written.kind);
  EXPECT_EQ(read.label, written.label);
  EXPECT_EQ(read.tiny, written.tiny);
  EXPECT_EQ(read.third, written.third);
  EXPECT_EQ(ConfigText(set), text);
}

TEST(Config, AcceptsCommentsTablesDottedKeysAndBothStrings) {
  SampleOptions options;
  OptionSet set = options.Describe();
  ParseConfig(
      "# a comment\r\n"
      "label = 'C:\\no # escapes' # after a value\n"
      "level.count = +1_0\n"
      "\n"
      "\t[ smooth ]  # table\n"
      "weight=1_0.5e-1\n"
      "  enabled = false\n"
      "\"kind\" = \"\\u0062ilaplacian\"",
      "c.toml", &set);
  EXPECT_EQ(options.label, "C:\\no # escapes");
  EXPECT_EQ(options.count, 10);
  EXPECT_EQ(options.weight, 1.05);
  EXPECT_FALSE(options.enabled);
  EXPECT_EQ(options.kind, Kind::kBilaplacian);
  ParseConfig("smooth.weight = 0x10\nlabel = \"\"\"\none\ntwo\"\"\"\n[empty]\n", "c.toml", &set);
  EXPECT_EQ(options.weight, 16);
  EXPECT_EQ(options.label, "one\ntwo");
}

TEST(Config, ErrorsNameFileLineKeyAndReason) {
  EXPECT_EQ(ConfigError("\n[smooth]\nwieght = 1"),
            "c.toml:3: smooth.wieght: unknown option (did you mean smooth.weight?)");
  EXPECT_EQ(ConfigError("[level]\ncount = 2\ncount = 3"),
            "c.toml:3: count = 3: Error while parsing key-value pair: cannot redefine existing "
            "integer 'count'");
  EXPECT_EQ(ConfigError("level.count = 2\n[level]\ncount = 3"),
            "c.toml:2: [level]: Error while parsing table header: cannot redefine existing table "
            "'level'");
  EXPECT_EQ(ConfigError("[level]\n[smooth]\n [level] \r\n"),
            "c.toml:3: [level]: Error while parsing table header: cannot redefine existing table "
            "'level'");
  EXPECT_EQ(
      ConfigError("\nsmooth.kind = umbrella"),
      "c.toml:2: smooth.kind = umbrella: Error while parsing value: could not determine value "
      "type (text needs quotes)");
  EXPECT_EQ(ConfigError("level.count = 11"),
            "c.toml:1: level.count: must be a whole number in [1, 10], not 11");
  EXPECT_EQ(ConfigError("level.count = 3.0"),
            "c.toml:1: level.count: must be a whole number in [1, 10], not 3.0");
  EXPECT_EQ(ConfigError("smooth.weight = \"3\""),
            "c.toml:1: smooth.weight: must be a number in [0, 1e+06], not \"3\"");
  EXPECT_EQ(ConfigError("smooth.enabled = 1"),
            "c.toml:1: smooth.enabled: must be true or false, not 1");
  EXPECT_EQ(ConfigError("smooth.kind = \"cotan\""),
            "c.toml:1: smooth.kind: must be one of umbrella, bilaplacian, not \"cotan\"");
  EXPECT_EQ(ConfigError("label = 3"), "c.toml:1: label: must be text, not 3");
  EXPECT_EQ(ConfigError("level.count = 3000000000"),
            "c.toml:1: level.count: must be a whole number in [1, 10], not 3000000000");
}

TEST(Config, TheFirstErrorOfTheFileIsTheOneThatIsNamed) {
  EXPECT_EQ(ConfigError("[smooth]\nz = 1\na = 1\n[level]\nb = 1"),
            "c.toml:2: smooth.z: unknown option");
}

// In TOML these are keys of one part, with a dot in it.
TEST(Config, AQuotedDotSeparatesNothing) {
  EXPECT_EQ(ConfigError("'smooth.weight' = 1"),
            "c.toml:1: \"smooth.weight\": unknown option (did you mean smooth.weight?)");
  EXPECT_EQ(ConfigError("[\"smooth.x\"]\n\"\" = 1"), "c.toml:2: \"smooth.x\".\"\": unknown option");
}

TEST(Config, RefusesKindsThatNoOptionTakes) {
  for (const auto& [value, kind] : std::vector<std::pair<std::string, std::string>>{
           {"[1]", "arrays"},
           {"{}", "inline tables"},
           {"{x = 1}", "inline tables"},
           {"1979-05-27", "dates and times"},
           {"07:32:00", "dates and times"},
           {"1979-05-27T07:32:00Z", "dates and times"}}) {
    EXPECT_EQ(ConfigError("smooth.weight = " + value),
              "c.toml:1: smooth.weight: " + kind + " are not supported");
  }
  EXPECT_EQ(ConfigError("[[smooth]]\nweight = 1"),
            "c.toml:1: smooth: arrays of tables are not supported");
}

// Tables in tables are read and destroyed by recursion.
TEST(Config, DeepNestingIsAnError) {
  const auto repeated = [](const std::string& piece, int count) {
    std::string text;
    for (int k = 0; k < count; ++k) text += piece;
    return text;
  };
  for (const int depth : {4000, 200000}) {
    for (const std::string& text :
         {repeated("a.", depth) + "a = 1", "[" + repeated("a.", depth) + "a]\nb = 1",
          "a = " + repeated("[", depth), "a = " + repeated("{a=", depth)}) {
      EXPECT_THAT(ConfigError(text), testing::StartsWith("c.toml:")) << text.substr(0, 20);
    }
  }
}

TEST(Config, RefusesWhatIsNotToml) {
  for (const char* text : {"smooth.weight = nan",
                           "smooth.weight = inf",
                           "smooth.weight = 1e999",
                           "smooth.weight = .5",
                           "smooth.weight = 1.",
                           "smooth.weight = 007",
                           "smooth.weight = 1__0",
                           "smooth.weight =",
                           "smooth.weight",
                           "= 3",
                           "smooth.weight = 1 2",
                           "smooth.weight = abc",
                           "[smooth",
                           "[smooth] x = 1",
                           "[]",
                           "[smooth.]",
                           "label = x",
                           "label = \"x",
                           "label = 'x",
                           "label = \"\xFF\"",
                           "\xFF\xFE",
                           "label = 'a' # \xC3(",
                           "label = \"\\q\"",
                           "label = \"\\uD800\"",
                           "label = \"\\u12\"",
                           "label = \"x\" y",
                           "label = \"a\x01\"",
                           "level.count = 99999999999999999999"}) {
    EXPECT_THAT(ConfigError(text), HasSubstr("c.toml:1: ")) << text;
  }
}

TEST(Config, MissingFileAndFolderAreErrors) {
  SampleOptions options;
  OptionSet set = options.Describe();
  EXPECT_THROW(ReadConfig("/nonexistent/c.toml", &set), InputError);
  EXPECT_THROW(ReadConfig(testing::TempDir(), &set), InputError);
}

TEST(OptionBinding, FlagsSetTheStruct) {
  SampleOptions options;
  Parse(&options, {"--smooth.weight", "2.5", "--smooth.enabled=false", "--level.count", "4",
                   "--smooth.kind", "bilaplacian", "--solver.third", "-2"});
  EXPECT_EQ(options.weight, 2.5);
  EXPECT_FALSE(options.enabled);
  EXPECT_EQ(options.count, 4);
  EXPECT_EQ(options.kind, Kind::kBilaplacian);
  EXPECT_EQ(options.third, -2);
}

TEST(OptionBinding, ABooleanFlagNeedsNoValue) {
  for (const auto& [arguments, expected] : std::vector<std::pair<std::vector<std::string>, bool>>{
           {{"--smooth.enabled"}, true},
           {{"--smooth.enabled", "true"}, true},
           {{"--smooth.enabled", "false"}, false},
           {{"--smooth.enabled=false"}, false}}) {
    SampleOptions options;
    options.enabled = !expected;
    Parse(&options, arguments);
    EXPECT_EQ(options.enabled, expected) << arguments.back();
  }
}

TEST(OptionBinding, ShortFlagsAreASecondSpelling) {
  CLI::App app;
  SampleOptions options;
  OptionSet set = options.Describe();
  BindOptions(&set, &app, {{"level.count", "--levels"}});
  app.parse(std::vector<std::string>{"8", "--levels"});
  EXPECT_EQ(options.count, 8);
  EXPECT_THROW(app.parse(std::vector<std::string>{"1", "--level.count", "2", "--levels"}),
               CLI::ParseError);
}

TEST(OptionBinding, FlagsOverrideConfigWhateverTheirOrder) {
  const TemporaryFile first("first.toml", "[smooth]\nweight = 5\nkind = \"bilaplacian\"\n");
  const TemporaryFile second("second.toml", "smooth.weight = 6\nlevel.count = 2\n");
  SampleOptions options;
  Parse(&options, {"--level.count", "9", "--config", first.path(), "--config", second.path()});
  EXPECT_EQ(options.count, 9);
  EXPECT_EQ(options.weight, 6);
  EXPECT_EQ(options.kind, Kind::kBilaplacian);
}

TEST(OptionBinding, BadFlagsAreErrors) {
  SampleOptions options;
  EXPECT_THROW(Parse(&options, {"--smooth.weight", "-1"}), InputError);
  EXPECT_THROW(Parse(&options, {"--smooth.weight", "1x"}), InputError);
  EXPECT_THROW(Parse(&options, {"--smooth.enabled", "yes"}), InputError);
  EXPECT_THROW(Parse(&options, {"--smooth.weight"}), CLI::ParseError);
  EXPECT_THROW(Parse(&options, {"--smooth.weight", "1", "--smooth.weight", "2"}), CLI::ParseError);
  EXPECT_THROW(Parse(&options, {"--smooth.wieght", "1"}), CLI::ParseError);
}

TEST(OptionBinding, PrintConfigShowsFlagsAndReadsBack) {
  SampleOptions options;
  testing::internal::CaptureStdout();
  EXPECT_THROW(Parse(&options, {"--print-config", "--smooth.weight", "0.25"}), CLI::Success);
  const std::string text = testing::internal::GetCapturedStdout();
  EXPECT_EQ(ConfigText(options.Describe()), text);
  SampleOptions read;
  OptionSet set = read.Describe();
  ParseConfig(text, "printed", &set);
  EXPECT_EQ(read.weight, 0.25);
  EXPECT_THROW(Parse(&options, {"--print-config", "--no-such"}), CLI::ParseError);
}

TEST(OptionBinding, HelpGroupsOptionsAndShowsDefaultAndConstraint) {
  CLI::App app;
  SampleOptions options;
  OptionSet set = options.Describe();
  BindOptions(&set, &app);
  const std::string help = app.help();
  EXPECT_THAT(help, HasSubstr("\nsmooth:\n"));
  EXPECT_THAT(help, HasSubstr("--smooth.weight NUMBER"));
  EXPECT_THAT(help, HasSubstr("factor of the term (a number in [0, 1e+06]; default 0.1)"));
  EXPECT_LT(help.find("--level.count"), help.find("--solver.third"));
}

TEST(OptionBinding, JsonKeepsTypesAndOrder) {
  SampleOptions options;
  const nlohmann::ordered_json json = OptionsJson(options.Describe());
  EXPECT_EQ(json.size(), 7U);
  EXPECT_EQ(json.begin().key(), "smooth.enabled");
  EXPECT_TRUE(json["smooth.enabled"].is_boolean());
  EXPECT_TRUE(json["level.count"].is_number_integer());
  EXPECT_EQ(json["solver.third"].get<double>(), 1.0 / 3.0);
  EXPECT_EQ(json["smooth.kind"], "umbrella");
}

TEST(OptionBinding, MarkdownHasOneRowForEachOption) {
  SampleOptions options;
  const std::string text = OptionsMarkdown(options.Describe());
  EXPECT_THAT(text, HasSubstr("## level\n"));
  EXPECT_THAT(text, HasSubstr("| `--smooth.weight` | `0.1` | a number in [0, 1e+06] | factor"));
  EXPECT_THAT(text, HasSubstr("name of the run \\| free text"));
  size_t rows = 0;
  for (size_t at = text.find("| `--"); at != std::string::npos; at = text.find("| `--", at + 1)) {
    ++rows;
  }
  EXPECT_EQ(rows, 7U);
}

}  // namespace
}  // namespace burin
