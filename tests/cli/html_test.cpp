// --html: what a page holds, and how it is refused. Whether it works in a browser, tests/html tells.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "process.h"
#include "refusal.h"
#include "sample_files.h"

namespace handhold::test {
namespace {

using Json = nlohmann::ordered_json;
using Words = std::vector<std::string>;

class HtmlOutput : public ::testing::Test {
 protected:
  HtmlOutput() { folder_.write("cloud.pcd", binary_pcd(cylinder())); }

  std::string output(const Words& words) {
    const Outcome done = run_program(words, folder_.path());
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    return done.out;
  }
  void expect_refused(const Words& words, int exit_code, const Words& parts) {
    expect_one_line_refusal(
        folder_,
        [&](const Words& more) {
          Words all = {"localize", "cloud.pcd"};
          all.insert(all.end(), more.begin(), more.end());
          return run_program(all, folder_.path());
        },
        words, exit_code, parts);
  }

  Folder folder_;
};

#ifdef HANDHOLD_WITH_HTML

/// Text of the script element with an id.
std::string element(const std::string& page, const std::string& id) {
  const std::string start = "<script id=\"" + id + "\" type=\"";
  std::size_t from = page.find(start);
  EXPECT_NE(from, std::string::npos) << id;
  from = page.find('>', from) + 1;
  return page.substr(from, page.find("</script>", from) - from);
}
std::size_t base64_length(std::size_t bytes) {
  return (bytes + 2) / 3 * 4;
}

TEST_F(HtmlOutput, HoldsTheResultAndTheCloud) {
  const std::string table = output({"localize", "cloud.pcd", "--no-times"});
  EXPECT_EQ(output({"localize", "cloud.pcd", "--no-times", "--html", "out.html"}), table);
  EXPECT_EQ(folder_.entries(), (Words{"cloud.pcd", "out.html"}));
  const std::string page = folder_.read("out.html");
  const Json result = Json::parse(element(page, "result"));
  EXPECT_EQ(result, Json::parse(output({"localize", "cloud.pcd", "--no-times", "--json", "-"})));
  ASSERT_FALSE(result["handles"].empty());

  const Json view = Json::parse(element(page, "view-data"));
  EXPECT_EQ(view["schema"], "handhold.view/1");
  EXPECT_EQ(view["name"], "cloud.pcd");
  const std::size_t points = view["cloud"]["points"], samples = view["samples"];
  EXPECT_EQ(points, result["cloud"]["finite"]);
  EXPECT_EQ(samples, result["funnel"]["samples"]);
  EXPECT_EQ(element(page, "positions").size(), base64_length(6 * points));
  EXPECT_EQ(element(page, "colors").size(), 0u);
  EXPECT_EQ(element(page, "samples").size(), base64_length(6 * samples));
  EXPECT_EQ(element(page, "steps").size(), base64_length(samples));
  for (const char* steps : {"sample_steps", "affordance_steps"}) {
    for (const Json& step : view[steps]) EXPECT_EQ(step["count"], result["funnel"][step["name"].get<std::string>()]);
  }
  EXPECT_FALSE(view.contains("plan"));
}

TEST_F(HtmlOutput, TheSameRunGivesTheSameBytes) {
  output({"localize", "cloud.pcd", "--html", "a.html", "--threads", "1"});
  output({"localize", "cloud.pcd", "--html", "b.html", "--threads", "2", "--json", "b.json", "--picture", "b.png"});
  EXPECT_EQ(folder_.read("a.html"), folder_.read("b.html"));
  output({"localize", "cloud.pcd", "--html", "c.html", "--seed", "2"});
  EXPECT_NE(folder_.read("a.html"), folder_.read("c.html"));
}

TEST_F(HtmlOutput, IsCompactAndAsksNoNetwork) {
  output({"localize", "cloud.pcd", "--html", "out.html"});
  const std::string page = folder_.read("out.html");
  const Json result = Json::parse(element(page, "result"));
  const std::size_t program = 1'000'000, points = result["cloud"]["finite"], samples = result["funnel"]["samples"];
  EXPECT_LT(page.size(), program + element(page, "result").size() + 8 * points + 10 * samples);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
  for (const char* fetch : {" src=", " href=", "@import", "url("}) {
    EXPECT_EQ(page.substr(0, page.find("three.js authors")).find(fetch), std::string::npos) << fetch;
  }
}

TEST_F(HtmlOutput, AFileNameIsText) {
  std::filesystem::create_symlink("cloud.pcd", folder_.path() / "<script>alert(1)<b>&.pcd");
  output({"localize", "<script>alert(1)<b>&.pcd", "--html", "out.html"});
  const std::string page = folder_.read("out.html");
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_NE(page.find("<title>&lt;script&gt;alert(1)&lt;b&gt;&amp;.pcd"), std::string::npos);
  EXPECT_EQ(Json::parse(element(page, "view-data"))["name"], "<script>alert(1)<b>&.pcd");
}

TEST_F(HtmlOutput, Refusals) {
  expect_refused({"--html", "-"}, 2, {"--html", "standard output"});
  expect_refused({"--html", "cloud.pcd"}, 2, {"--html", "overwrite", "cloud.pcd"});
  expect_refused({"--html", "out", "--json", "out"}, 2, {"--json", "--html", "'out'"});
  expect_refused({"--html", "./out", "--picture", "out"}, 2, {"--picture", "--html", "out"});
  expect_refused({"--html", "none/out.html"}, 1, {"none/out.html", "create the folder"});
  expect_refused({"--html", "."}, 1, {"cannot write '.'"});
  expect_refused({"--html"}, 2, {"--html"});
  folder_.write("empty.pcd", ascii_pcd({}));
  const Outcome done = run_program({"localize", "empty.pcd", "--html", "out.html"}, folder_.path());
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_EQ(folder_.entries(), (Words{"cloud.pcd", "empty.pcd"}));
}

TEST_F(HtmlOutput, AFullDiskLeavesTheOldFile) {
  folder_.write("out.html", "old");
  Surroundings around;
  around.max_file_bytes = 100'000;
  const Outcome done = run_program({"localize", "cloud.pcd", "--html", "out.html"}, folder_.path(), around);
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_EQ(done.err.rfind("handhold: error: cannot write 'out.html'", 0), 0u) << done.err;
  EXPECT_EQ(folder_.read("out.html"), "old");
  EXPECT_EQ(folder_.entries(), (Words{"cloud.pcd", "out.html"}));
}

#ifdef HANDHOLD_WITH_PLAN
TEST_F(HtmlOutput, HoldsPlannedGrasps) {
  const Words words = {"plan", "cloud.pcd", "--camera-pose", "0.05", "-0.2", "0.15", "-0.5", "0.5", "-0.5", "0.5"};
  const auto with = [&](const Words& more) {
    Words all = words;
    all.insert(all.end(), more.begin(), more.end());
    return output(all);
  };
  with({"--html", "out.html"});
  const std::string page = folder_.read("out.html");
  const Json view = Json::parse(element(page, "view-data")), plan = Json::parse(with({"--json", "-"}));
  EXPECT_EQ(Json::parse(element(page, "result"))["handles"], plan["handles"]);
  ASSERT_EQ(view["plan"]["grasps"].size(), 1u);
  const Json &shown = view["plan"]["grasps"][0], &grasp = plan["grasps"][0];
  for (const char* name : {"handle", "width", "opening"}) EXPECT_EQ(shown[name], grasp[name]);
  EXPECT_EQ(shown["time"], grasp["times"].back());
  EXPECT_EQ(view["plan"]["tip"], grasp["frame"]);
  ASSERT_GE(shown["hand"].size(), 3u) << "a palm and two fingers";
  // The robot's z is the optical frame's -y here, and the hand ends at the part.
  EXPECT_NEAR(view["start"]["up"][1].get<double>(), -1, 1e-9);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(shown["to"][k].get<double>(), plan["handles"][0]["center"][k].get<double>(), 0.05);
  }
  with({"--html", "again.html", "--threads", "1"});
  EXPECT_EQ(folder_.read("again.html"), page);
  const Outcome refused = run_program(Words(words.begin(), words.begin() + 2), folder_.path());
  EXPECT_EQ(refused.exit_code, 2);
}
#endif

#else

TEST_F(HtmlOutput, IsNotInThisBuild) {
  expect_refused({"--html", "out.html"}, 1, {"--html", "libjs-three"});
}

#endif

}  // namespace
}  // namespace handhold::test
