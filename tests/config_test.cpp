// Options from and to text.
#include "handhold/config.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <type_traits>

namespace handhold {
namespace {

/// Runs `action`, which must throw E, and returns the message.
template <class E, class Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const E& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

std::string toml_error(const std::string& text) {
  Options options;
  const std::string before = to_toml(options);
  const std::string message = message_of<ConfigError>([&] { apply_toml(options, text, "hand.toml"); });
  EXPECT_EQ(to_toml(options), before) << "a configuration that fails must change nothing";
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  EXPECT_NE(message.find("hand.toml"), std::string::npos) << message;
  return message;
}

// A value of each type that differs from every default.
void change(int& field) {
  field += 7;
}
void change(std::uint64_t& field) {
  field = 123456789012345;
}
void change(double& field) {
  field = field / 3 + 0.001;
}
void change(std::optional<double>& field) {
  field = 1.0 / 3;
}
void change(std::vector<double>& field) {
  field = {0.1 + 0.2, 1e-7, 2};
}
void change(std::optional<std::array<double, 6>>& field) {
  field = {-1, 1, -0.5, 1.0 / 3, 0, 1e6};
}
template <class T>
std::enable_if_t<std::is_enum_v<T>> change(T& field) {
  field = static_cast<T>(1);
}

template <class A, class B>
bool equal(const A& a, const B& b) {
  if constexpr (std::is_same_v<A, B>) return a == b;
  return false;
}

/// Names of the fields in which the two differ.
std::string differences(const Options& a, const Options& b) {
  std::string names;
  visit_options(a, [&](const auto& field_a, const OptionInfo& info_a) {
    visit_options(b, [&](const auto& field_b, const OptionInfo& info_b) {
      if (std::string(info_a.name) == info_b.name && !equal(field_a, field_b)) names += std::string(info_a.name) + " ";
    });
  });
  return names;
}

Options all_changed() {
  Options options;
  visit_options(options, [](auto& field, const OptionInfo&) { change(field); });
  return options;
}

TEST(Config, DefaultsSurviveTheRoundTrip) {
  Options read = all_changed();
  apply_toml(read, to_toml(Options()), "text");
  EXPECT_EQ(differences(read, Options()), "");  // also what is unset is unset again
}

TEST(Config, EveryChangedOptionSurvivesTheRoundTripBitForBit) {
  const Options changed = all_changed();
  for (const std::string& name : option_names()) {
    EXPECT_NE(differences(changed, Options()).find(name), std::string::npos) << name << " was not changed by this test";
  }
  Options read;
  const ConfigLines lines = apply_toml(read, to_toml(changed), "text");
  EXPECT_EQ(differences(read, changed), "");
  EXPECT_EQ(lines.size(), option_names().size());
}

TEST(Config, EachOptionAloneLeavesTheOthersAlone) {
  const Options changed = all_changed();
  const std::string all = to_toml(changed);
  for (const std::string& name : option_names()) {
    const std::size_t begin = all.find("\n" + name + " = ") + 1;
    ASSERT_NE(begin, 0u) << name;
    Options read;
    apply_toml(read, all.substr(begin, all.find('\n', begin) - begin), "text");
    EXPECT_EQ(differences(read, Options()), name + " ");
  }
}

TEST(Config, EveryOptionFromItsTextAlone) {
  const Options changed = all_changed();
  const std::string all = to_toml(changed);
  Options read;
  for (const std::string& name : option_names()) {
    const std::size_t begin = all.find("\n" + name + " = ") + name.size() + 4;
    std::string text = all.substr(begin, all.find('\n', begin) - begin);
    for (char& c : text) {
      if (c == '[' || c == ']' || c == '"') c = ' ';
    }
    set_option(read, name, text);
  }
  EXPECT_EQ(differences(read, changed), "");
}

TEST(Config, ExtremeSeedSurvives) {
  Options options, read;
  options.seed = std::numeric_limits<std::uint64_t>::max();
  apply_toml(read, to_toml(options), "text");
  EXPECT_EQ(read.seed, options.seed);
}

TEST(Config, WholeNumbersAndSingleNumbersAreWelcome) {
  Options options;
  apply_toml(options, "radius = 0.03\nshell_gap_area_mm2 = 5\n", "text");
  EXPECT_EQ(options.radius, std::vector<double>{0.03});
  EXPECT_EQ(options.shell_gap_area_mm2, 5.0);
}

TEST(Config, LinesTellWhereAKeyStands) {
  Options options;
  const ConfigLines lines = apply_toml(options, "# a comment\n\nsamples = 10\nreach = 0.1\n", "text");
  EXPECT_EQ(lines, (ConfigLines{{"samples", 3}, {"reach", 4}}));
}

TEST(Config, UnknownKeySaysNameLineAndNearest) {
  const std::string message = toml_error("samples = 10\nhand_apperture = 0.1\n");
  EXPECT_NE(message.find("line 2"), std::string::npos) << message;
  EXPECT_NE(message.find("'hand_apperture'"), std::string::npos) << message;
  EXPECT_NE(message.find("'hand_aperture'"), std::string::npos) << message;
}

TEST(Config, FirstOfSeveralMistakesIsReported) {
  EXPECT_NE(toml_error("zzzz = 1\naaaa = 1\n").find("line 1"), std::string::npos);
}

TEST(Config, UnknownTableIsRefused) {
  EXPECT_NE(toml_error("[hand]\naperture = 0.1\n").find("unknown table 'hand'"), std::string::npos);
  EXPECT_NE(toml_error("[samples]\nn = 1\n").find("whole number"), std::string::npos);
}

TEST(Config, WrongTypesAreRefusedWithLineAndValue) {
  for (const char* line :
       {"samples = \"many\"", "samples = 10.5", "samples = true", "seed = -1", "seed = \"12x\"", "seed = \"\"",
        "radius = \"wide\"", "radius = [0.01, \"wide\"]", "hand_aperture = [0.1]", "reach = \"far\"",
        "workspace = [1, 2, 3]", "workspace = 1", "method = 1", "strategy = \"best\"", "backend = \"gpu\"",
        "samples = 3000000000", "threads = 1979-05-27"}) {
    const std::string message = toml_error("\n" + std::string(line));
    EXPECT_NE(message.find("line 2"), std::string::npos) << message;
  }
}

TEST(Config, TextThatIsNoTomlIsRefusedWithItsLine) {
  EXPECT_NE(toml_error("samples = 10\nsamples = = 3\n").find("line 2"), std::string::npos);
  EXPECT_NE(toml_error("samples = 10\nsamples = 11\n").find("line 2"), std::string::npos);
  toml_error("samples");
  toml_error(std::string("\0\1\2\xff", 4));
}

TEST(Config, FilesThatCannotBeReadAreNamed) {
  Options options;
  const std::string folder = std::filesystem::temp_directory_path().string();
  EXPECT_NE(message_of<ConfigError>([&] { apply_toml_file(options, folder); }).find("folder"), std::string::npos);
  EXPECT_NE(message_of<ConfigError>([&] { apply_toml_file(options, "no/such.toml"); }).find("'no/such.toml'"),
            std::string::npos);
}

TEST(SetOption, RefusesWhatIsNoValue) {
  Options options;
  const std::pair<const char*, const char*> wrong[] = {
      {"samples", "many"},        {"samples", ""},          {"samples", "5e3"},     {"samples", "99999999999"},
      {"samples", "10 20"},       {"seed", "-1"},           {"radius", ""},         {"radius", "nan"},
      {"radius", "0.01 inf"},     {"radius", "0.01 x"},     {"radius", "0x10"},     {"hand_aperture", "0.1 0.2"},
      {"hand_aperture", "1e999"}, {"hand_aperture", "+-1"}, {"workspace", "1 2 3"}, {"workspace", "none"},
      {"reach", "far"},           {"strategy", "best"},     {"method", ""},         {"backend", "gpu"}};
  for (const auto& [name, text] : wrong) {
    EXPECT_THROW(set_option(options, name, text), OptionError) << name << " = " << text;
  }
  EXPECT_EQ(differences(options, Options()), "");
  const std::string message = message_of<OptionError>([&] { set_option(options, "sampels", "10"); });
  EXPECT_NE(message.find("'samples'"), std::string::npos) << message;
}

TEST(SetOption, TakesBlanksCommasAndSigns) {
  Options options;
  set_option(options, "radius", " 0.01, +0.02\t3e-2 ");
  EXPECT_EQ(options.radius, (std::vector<double>{0.01, 0.02, 0.03}));
  set_option(options, "reach", "0.1");
  EXPECT_EQ(options.reach, 0.1);
  set_option(options, "reach", "default");
  EXPECT_FALSE(options.reach.has_value());
  set_option(options, "radius", "default");
  EXPECT_TRUE(options.radius.empty());
}

TEST(GetOption, EveryOptionSurvivesItsTextBitForBit) {
  for (const Options& options : {Options(), all_changed(), Options::baxter()}) {
    Options read = all_changed();
    for (const std::string& name : option_names()) set_option(read, name, get_option(options, name));
    EXPECT_EQ(differences(read, options), "");
  }
}

TEST(GetOption, WritesWhatOneWouldWrite) {
  Options options;
  EXPECT_EQ(get_option(options, "hand_aperture"), "0.08");
  EXPECT_EQ(get_option(options, "samples"), "5000");
  EXPECT_EQ(get_option(options, "method"), "default");
  EXPECT_EQ(get_option(options, "reach"), "default");
  EXPECT_EQ(get_option(options, "radius"), "default");
  options.radius = {0.01, 0.025};
  EXPECT_EQ(get_option(options, "radius"), "0.01 0.025");
  const std::string message = message_of<OptionError>([&] { get_option(options, "hand-aperture"); });
  EXPECT_NE(message.find("'hand_aperture'"), std::string::npos) << message;
}

TEST(NearestName, FindsSlipsAndPartsAndNothingFarFetched) {
  const std::vector<std::string> names = option_names();
  EXPECT_EQ(nearest_name("smaples", names), "samples");
  EXPECT_EQ(nearest_name("hand-aperture", names), "hand_aperture");
  EXPECT_EQ(nearest_name("aperture", {"picture", "hand_aperture"}), "hand_aperture");
  EXPECT_EQ(nearest_name("sample", {"samples_per_frame", "simple", "samples"}), "simple");
  EXPECT_EQ(nearest_name("qqqqqqqq", names), "");
  EXPECT_EQ(nearest_name("", names), "");
}

}  // namespace
}  // namespace handhold
