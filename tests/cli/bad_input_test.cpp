// Whatever is wrong: one line on standard error, the right exit code, and no file left behind.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "process.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

using Words = std::vector<std::string>;

class BadInput : public ::testing::Test {
 protected:
  BadInput() { folder_.write("cloud.pcd", binary_pcd(cylinder())); }

  /// Runs `handhold localize arguments` and expects one line of error with all of `parts` in it, and nothing else.
  void expect_refusal(const Words& arguments, int exit_code, const Words& parts, const Surroundings& around = {}) {
    Words words = {"localize"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::string command;
    for (const std::string& word : words) command += word + " ";
    SCOPED_TRACE(command);
    const Words before = folder_.entries();
    const Outcome done = run_program(words, folder_.path(), around);
    EXPECT_EQ(done.exit_code, exit_code) << done.err;
    EXPECT_EQ(done.out, "");
    EXPECT_EQ(done.err.rfind("handhold: error: ", 0), 0u) << done.err;
    EXPECT_EQ(done.err.find('\n'), done.err.size() - 1) << done.err;
    for (const std::string& part : parts)
      EXPECT_NE(done.err.find(part), std::string::npos) << part << " in " << done.err;
    EXPECT_EQ(folder_.entries(), before);
  }

  /// A file of that content is refused with exit code 1, by name, and no JSON appears.
  void expect_bad_file(const std::string& name, const std::string& bytes) {
    folder_.write(name, bytes);
    expect_refusal({name, "--json", "out.json"}, 1, {name});
  }

  Folder folder_;
};

TEST_F(BadInput, NoSuchFile) {
  expect_refusal({"none.pcd", "--json", "out.json"}, 1, {"none.pcd"});
}

TEST_F(BadInput, AFolder) {
  expect_refusal({".", "--json", "out.json"}, 1, {"."});
}

TEST_F(BadInput, AnEmptyFile) {
  expect_bad_file("empty.pcd", "");
  expect_bad_file("empty.ply", "");
}

TEST_F(BadInput, AFileOfAnotherKind) {
  expect_bad_file("text.pcd", "This is no cloud.\nIt has two lines.\n");
  expect_bad_file("text.ply", "This is no cloud.\nIt has two lines.\n");
}

TEST_F(BadInput, ATruncatedHeader) {
  const std::string pcd = binary_pcd(cylinder());
  const std::string ply = ascii_ply(cylinder());
  for (const std::size_t length : {20u, 60u, 90u, 120u, 160u}) expect_bad_file("cut.pcd", pcd.substr(0, length));
  for (const std::size_t length : {3u, 20u, 60u}) expect_bad_file("cut.ply", ply.substr(0, length));
}

TEST_F(BadInput, TruncatedData) {
  const std::string binary = binary_pcd(cylinder());
  expect_bad_file("cut.pcd", binary.substr(0, binary.size() / 2));
  expect_bad_file("one_byte_less.pcd", binary.substr(0, binary.size() - 1));
  const std::string ascii = ascii_pcd(cylinder());
  expect_bad_file("cut_ascii.pcd", ascii.substr(0, ascii.size() / 2));
  const std::string ply = ascii_ply(cylinder());
  expect_bad_file("cut.ply", ply.substr(0, ply.size() / 2));
}

TEST_F(BadInput, NoCloudOrTwo) {
  expect_refusal({}, 2, {"no cloud"});
  expect_refusal({"cloud.pcd", "other.pcd"}, 2, {"'other.pcd'"});
  expect_refusal({"cloud.pcd", "--depth", "x.png"}, 2, {"cloud.pcd", "--depth"});
}

TEST_F(BadInput, CloudsInWhichNothingCanBeFoundFailWithTheirStatus) {
  const auto expect_status = [&](const Points& points, const char* status, const Words& parts) {
    folder_.write("odd.pcd", ascii_pcd(points));
    Words words = {"odd.pcd"};
    expect_refusal(words, 1, parts);
    const Outcome done = run_program({"localize", "odd.pcd", "--json", "-"}, folder_.path());
    EXPECT_EQ(done.exit_code, 1);
    EXPECT_EQ(nlohmann::json::parse(done.out)["status"], status);
    EXPECT_EQ(done.err.find('\n'), done.err.size() - 1) << done.err;
  };
  expect_status({}, "empty", {"odd.pcd", "no points"});
  expect_status(Points(100, {NAN, NAN, NAN}), "no_finite_points", {"odd.pcd", "no finite point"});
  expect_status(Points(5, {0, 0, 1}), "too_few_points", {"odd.pcd", "only 5", "--min-neighbours"});
  expect_refusal({"cloud.pcd", "--workspace", "5", "6", "5", "6", "5", "6"}, 1,
                 {"cloud.pcd", "none inside --workspace"});
  Points millimetres = cylinder();
  for (auto& p : millimetres) {
    for (float& value : p) value *= 20000;
  }
  expect_status(millimetres, "suspicious_units", {"odd.pcd", "2.98 km wide", "millimetre", "metres"});
}

TEST_F(BadInput, ValuesOutOfRange) {
  const std::vector<Words> wrong = {{"--samples", "0"},
                                    {"--samples", "-1"},
                                    {"--samples", "1000000000"},
                                    {"--samples", "99999999999999999999"},
                                    {"--radius", "0"},
                                    {"--radius", "-1"},
                                    {"--radius", "nan"},
                                    {"--radius", "inf"},
                                    {"--radius", "0.025", "0"},
                                    {"--hand-aperture", "0"},
                                    {"--hand-aperture", "-1"},
                                    {"--hand-aperture", "nan"},
                                    {"--hand-minimum", "-1"},
                                    {"--min-neighbours", "9"},
                                    {"--min-confidence", "1.5"},
                                    {"--threads", "-1"},
                                    {"--finger-thickness", "0"},
                                    {"--workspace", "1", "0", "0", "1", "0", "1"},
                                    {"--workspace", "0", "1", "0", "1"},
                                    {"--repeat", "0"},
                                    {"--repeat", "1.5"},
                                    {"--viewpoint", "1", "2"},
                                    {"--viewpoint", "somewhere"}};
  for (const Words& flag : wrong) {
    Words words = {"cloud.pcd", "--json", "out.json"};
    words.insert(words.end(), flag.begin(), flag.end());
    expect_refusal(words, 2, {flag[0]});
  }
  expect_refusal({"cloud.pcd", "--hand-aperture", "0.02", "--hand-minimum", "0.03"}, 2, {"hand"});
}

TEST_F(BadInput, ValuesOfAWrongKind) {
  for (const char* flag : {"--samples", "--seed", "--radius", "--strategy", "--method", "--reach", "--axis", "--index",
                           "--hand", "--repeat", "--workspace"}) {
    expect_refusal({"cloud.pcd", flag, "bogus"}, 2, {flag, "bogus"});
    expect_refusal({"cloud.pcd", flag, ""}, 2, {flag});
    expect_refusal({"cloud.pcd", flag}, 2, {flag});
    expect_refusal({flag, "--explain", "cloud.pcd"}, 2, {flag});
  }
}

TEST_F(BadInput, UnknownOptionSuggestsTheNearest) {
  expect_refusal({"cloud.pcd", "--hand-apperture", "0.1"}, 2, {"'--hand-apperture'", "'--hand-aperture'"});
  expect_refusal({"cloud.pcd", "--sampels=10"}, 2, {"'--sampels'", "'--samples'"});
  expect_refusal({"cloud.pcd", "--qqqqqq"}, 2, {"'--qqqqqq'", "--help"});
  expect_refusal({"cloud.pcd", "-q"}, 2, {"'-q'"});
}

TEST_F(BadInput, UnknownSubcommandSuggestsTheNearest) {
  const Outcome done = run_program({"localise", "cloud.pcd"}, folder_.path());
  EXPECT_EQ(done.exit_code, 2);
  EXPECT_NE(done.err.find("'localize'"), std::string::npos) << done.err;
  EXPECT_EQ(run_program({}, folder_.path()).exit_code, 2);
}

TEST_F(BadInput, Configuration) {
  folder_.write("unknown.toml", "samples = 10\n\nhand_apperture = 0.1\n");
  expect_refusal({"cloud.pcd", "--config", "unknown.toml"}, 2,
                 {"unknown.toml", "line 3", "'hand_apperture'", "'hand_aperture'"});
  folder_.write("type.toml", "samples = \"many\"\n");
  expect_refusal({"cloud.pcd", "--config", "type.toml"}, 2, {"type.toml", "line 1", "samples", "many"});
  folder_.write("range.toml", "# fine\nsamples = 0\n");
  expect_refusal({"cloud.pcd", "--config", "range.toml"}, 2, {"range.toml", "line 2", "samples"});
  folder_.write("broken.toml", "samples = [1, \n");
  expect_refusal({"cloud.pcd", "--config", "broken.toml"}, 2, {"broken.toml"});
  expect_refusal({"cloud.pcd", "--config", "none.toml"}, 2, {"none.toml"});
  expect_refusal({"cloud.pcd", "--config", "."}, 2, {"'.'"});
}

TEST_F(BadInput, DepthImages) {
  const Words camera = {"--fx", "300", "--fy", "300", "--cx", "79.5", "--cy", "59.5", "--depth-unit-m", "0.001"};
  const auto with_camera = [&](Words words) {
    words.insert(words.end(), camera.begin(), camera.end());
    return words;
  };
  folder_.write("depth.png", depth_png());
  for (std::size_t left_out = 0; left_out < camera.size(); left_out += 2) {
    Words words = with_camera({"--depth", "depth.png"});
    words.erase(words.begin() + 2 + static_cast<int>(left_out), words.begin() + 4 + static_cast<int>(left_out));
    expect_refusal(words, 2, {camera[left_out]});
    words.insert(words.end(), {camera[left_out], "nan"});
    expect_refusal(words, 2, {camera[left_out]});
  }
  for (const char* flag : {"--fx", "--fy", "--depth-unit-m"}) {
    Words words = with_camera({"--depth", "depth.png"});
    words.insert(words.end(), {flag, "0"});
    expect_refusal(words, 2, {flag});
  }
  expect_refusal(with_camera({"cloud.pcd"}), 2, {"--depth"});
  expect_refusal(with_camera({"--depth", "none.png"}), 1, {"none.png"});
  folder_.write("cut.png", depth_png().substr(0, 100));
  expect_refusal(with_camera({"--depth", "cut.png"}), 1, {"cut.png"});
  expect_refusal(with_camera({"--depth", "cloud.pcd"}), 1, {"cloud.pcd"});
}

TEST_F(BadInput, OutputsThatCannotWorkAreRefusedBeforeTheInputIsRead) {
  for (const char* flag : {"--json", "--picture"}) {
    expect_refusal({"none.pcd", flag, "no/such/folder/out"}, 1, {"'no/such/folder/out'", "folder 'no/such/folder'"});
    expect_refusal({"none.pcd", flag, "cloud.pcd/out"}, 1, {"cloud.pcd/out"});
    expect_refusal({"none.pcd", flag, "."}, 1, {"'.'"});
    expect_refusal({"none.pcd", flag, "out/"}, 1, {"'out/'"});
    expect_refusal({"none.pcd", flag, std::string(300, 'x')}, 1, {"xxx"});
    expect_refusal({"cloud.pcd", flag, "./cloud.pcd"}, 2, {flag, "cloud.pcd"});
  }
  expect_refusal({"none.pcd", "--json", "same", "--picture", "./same"}, 2, {"same"});
  expect_refusal({"none.pcd", "--picture", "-"}, 2, {"--picture"});
  expect_refusal({"none.pcd", "--show-samples"}, 2, {"--show-samples", "--picture"});
}

TEST_F(BadInput, AFolderWithoutPermission) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  std::filesystem::create_directory(folder_.path() / "closed");
  ::chmod((folder_.path() / "closed").c_str(), 0555);
  expect_refusal({"none.pcd", "--json", "closed/out.json"}, 1, {"closed/out.json"});
  ::chmod((folder_.path() / "closed").c_str(), 0755);
}

TEST_F(BadInput, FullDiskLeavesNoHalfFile) {
  Surroundings full;
  full.max_file_bytes = 300;
  expect_refusal({"cloud.pcd", "--json", "out.json"}, 1, {"'out.json'", "disk"}, full);
  expect_refusal({"cloud.pcd", "--picture", "out.png"}, 1, {"out.png"}, full);
}

TEST_F(BadInput, FullDiskLeavesTheOldFileAlone) {
  folder_.write("out.json", "the old one");
  Surroundings full;
  full.max_file_bytes = 300;
  expect_refusal({"cloud.pcd", "--json", "out.json"}, 1, {"'out.json'"}, full);
  EXPECT_EQ(folder_.read("out.json"), "the old one");
}

TEST_F(BadInput, FullDevices) {
  if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  expect_refusal({"cloud.pcd", "--json", "/dev/full"}, 1, {"/dev/full"});
  expect_refusal({"cloud.pcd", "--picture", "/dev/full"}, 1, {"/dev/full"});
  Surroundings around;
  around.standard_output = "/dev/full";
  expect_refusal({"cloud.pcd"}, 1, {"standard output"}, around);
  expect_refusal({"cloud.pcd", "--json", "-"}, 1, {"standard output"}, around);
  expect_refusal({"--print-options"}, 1, {"standard output"}, around);
  expect_refusal({"--help"}, 1, {"standard output"}, around);
}

TEST_F(BadInput, UnknownInstructionSet) {
  Surroundings around;
  around.environment = {{"HANDHOLD_ISA", "nonsense"}};
  expect_refusal({"cloud.pcd"}, 2, {"HANDHOLD_ISA", "nonsense"}, around);
}

}  // namespace
}  // namespace handhold::test
