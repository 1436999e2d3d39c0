// --backend: what searches, and what is said where it cannot be had. Where a GPU is there, what needs none to be is
// skipped.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "handhold/device.h"
#include "process.h"
#include "refusal.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

class BackendFlag : public ::testing::Test {
 protected:
  BackendFlag() {
    std::filesystem::create_directories(folder_.path() / "clouds");
    folder_.write("cloud.pcd", binary_pcd(cylinder()));
    for (const char* name : {"clouds/a.pcd", "clouds/b.pcd", "clouds/c.pcd"}) {
      folder_.write(name, binary_pcd(cylinder()));
    }
  }
  Outcome run(Words words) const {
    words.insert(words.end(), {"--samples", "300"});
    return run_program(words, folder_.path());
  }
  /// Standard output of a run that must succeed, with this on standard error.
  std::string output(const Words& words, const std::string& err = {}) const {
    const Outcome done = run(words);
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_EQ(done.err, err);
    return done.out;
  }
  /// The same text but for the option itself.
  static std::string as_of_cpu(const std::string& text) {
    const std::string name = "\"backend\":\"auto\"";
    std::string other = text;
    EXPECT_NE(other.find(name), std::string::npos) << text;
    for (std::size_t at; (at = other.find(name)) != std::string::npos;) {
      other.replace(at, name.size(), "\"backend\":\"cpu\"");
    }
    return other;
  }

  Folder folder_;
};

/// Without a GPU, or in a build without CUDA.
class WithoutGpu : public BackendFlag {
 protected:
  void SetUp() override {
    if (device_.available) GTEST_SKIP() << "there is a GPU here: " << device_.name;
  }
  std::string note() const { return "note: backend = auto: on the CPU: " + device_.reason + "\n"; }

  const CudaDevice device_ = cuda_device();
};

TEST_F(BackendFlag, VersionSaysWhetherThereIsAGpu) {
  const Outcome done = run_program({"--version"}, folder_.path());
  EXPECT_EQ(done.exit_code, 0) << done.err;
  std::istringstream text(done.out);
  std::string version, device;
  std::getline(text, version), std::getline(text, device);
  EXPECT_EQ(version.rfind("handhold ", 0), 0u) << done.out;
  const CudaDevice expected = cuda_device();
  EXPECT_EQ(device, expected.available ? "cuda: " + expected.name : "cuda: none: " + expected.reason);
  EXPECT_EQ(std::count(done.out.begin(), done.out.end(), '\n'), 2);
}

TEST_F(BackendFlag, UnknownNamesAreRefused) {
  expect_one_line_refusal(folder_, [&](const Words& words) { return run(words); },
                          {"localize", "cloud.pcd", "--backend", "gpu"}, 2,
                          {"--backend = 'gpu': must be one of 'cpu', 'cuda', 'auto'"});
}

TEST_F(BackendFlag, IsPrintedWithoutAGpu) {
  EXPECT_NE(output({"localize", "--print-options", "--backend", "cuda"}).find("backend = \"cuda\"\n"),
            std::string::npos);
}

TEST_F(BackendFlag, TheCpuIsNothingToTalkAbout) {
  const Json result = Json::parse(output({"localize", "cloud.pcd", "--json", "-"}));
  EXPECT_EQ(result["backend"], "cpu");
  EXPECT_EQ(result["options"]["backend"], "cpu");
  EXPECT_EQ(output({"localize", "cloud.pcd", "--explain"}).find("searched on"), std::string::npos);
}

TEST_F(WithoutGpu, CudaIsOneLineBeforeAnythingIsDone) {
  const std::string why = "backend = cuda: " + device_.reason + "; use 'cpu', or 'auto' to fall back\n";
  const auto refused = [&](const Words& words, const std::string& where) {
    expect_one_line_refusal(folder_, [&](const Words& w) { return run(w); }, words, 2,
                            {"handhold: error: " + where + why});
  };
  for (const Words& words :
       {Words{"localize", "cloud.pcd", "--json", "out.json"}, Words{"localize", "there_is_none.pcd"},
        Words{"batch", "clouds", "-o", "out"}, Words{"stream", "clouds", "--json", "out.jsonl"}}) {
    Words with = words;
    with.insert(with.end(), {"--backend", "cuda"});
    refused(with, "--");
  }
  folder_.write("gpu.toml", "seed = 3\nbackend = \"cuda\"\n");
  refused({"localize", "cloud.pcd", "--config", "gpu.toml"}, "gpu.toml, line 2: ");
  refused({"localize", "cloud.pcd", "--config", "gpu.toml", "--backend", "cuda"}, "--");
  EXPECT_EQ(run({"localize", "cloud.pcd", "--config", "gpu.toml", "--backend", "cpu"}).exit_code, 0) << "flags win";
}

#ifdef HANDHOLD_WITH_PLAN
TEST_F(WithoutGpu, PlanSaysTheSame) {
  Words words = {"plan", "cloud.pcd", "--camera-pose", "0 0 0 0 0 0 1", "--json", "-", "--backend"};
  const std::string cpu = [&] {
    Words w = words;
    w.push_back("cpu");
    return output(w);
  }();
  Words automatic = words;
  automatic.push_back("auto");
  EXPECT_EQ(output(automatic, note()), cpu);
  words.push_back("cuda");
  expect_one_line_refusal(folder_, [&](const Words& w) { return run(w); }, words, 2, {"--backend = cuda: "});
}
#endif

TEST_F(WithoutGpu, AutoIsTheCpuWithANote) {
  const Words words = {"localize", "cloud.pcd", "--no-times", "--json", "-", "--backend"};
  Words cpu = words, automatic = words;
  cpu.push_back("cpu"), automatic.push_back("auto");
  const std::string text = output(automatic, note());
  EXPECT_EQ(as_of_cpu(text), output(cpu));
  const Json result = Json::parse(text);
  EXPECT_EQ(result["backend"], "cpu");
  EXPECT_EQ(result["options"]["backend"], "auto");
  ASSERT_FALSE(result["handles"].empty());
}

TEST_F(WithoutGpu, RepeatAndExplainSayItOnce) {
  const std::string text = output({"localize", "cloud.pcd", "--backend", "auto", "--repeat", "3", "--explain"}, note());
  EXPECT_NE(text.find("searched on the CPU (backend = auto): " + device_.reason + "\n"), std::string::npos) << text;
}

TEST_F(WithoutGpu, BatchAndStreamNoteItOnce) {
  output({"batch", "clouds", "-o", "auto", "--threads", "2", "--backend", "auto"}, note());
  output({"batch", "clouds", "-o", "cpu", "--threads", "2"});
  for (const char* name : {"/a.json", "/b.json", "/c.json"}) {
    EXPECT_EQ(as_of_cpu(folder_.read("auto" + std::string(name))), folder_.read("cpu" + std::string(name)));
  }
  const Words words = {"stream", "clouds", "--no-times", "--json"};
  Words cpu = words, automatic = words;
  cpu.push_back("cpu.jsonl");
  automatic.insert(automatic.end(), {"auto.jsonl", "--backend", "auto"});
  output(automatic, note());
  output(cpu);
  EXPECT_EQ(folder_.read("auto.jsonl"), folder_.read("cpu.jsonl"));
  std::istringstream lines(folder_.read("auto.jsonl"));
  int frames = 0;
  for (std::string line; std::getline(lines, line); ++frames) EXPECT_EQ(Json::parse(line)["backend"], "cpu");
  EXPECT_EQ(frames, 3);
}

// 'auto' may become something else on another machine, or another day.
TEST_F(WithoutGpu, ABatchIsOfOneBackend) {
  const Words words = {"batch", "clouds", "-o", "out", "--backend", "auto"};
  output(words, note());
  output(words, note());
  std::string manifest = folder_.read("out/.handhold-batch.json");
  const std::size_t at = manifest.find("\"backend\": \"cpu\"");
  ASSERT_NE(at, std::string::npos) << manifest;
  folder_.write("out/.handhold-batch.json", manifest.replace(at, 16, "\"backend\": \"cuda\""));
  const Outcome refused = run(words);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("of another backend"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace handhold::test
