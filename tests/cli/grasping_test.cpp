// handhold experiment table1 and table2: small parts of them.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "experiment_fixture.h"

namespace handhold::test {
namespace {

class Grasping : public Experiment {
 protected:
  void SetUp() override {
#ifndef HANDHOLD_WITH_PHYSICS
    GTEST_SKIP() << "built without MuJoCo, KDL or urdfdom";
#endif
  }
};

TEST_F(Grasping, Table1OfOneObjectIsTheSameForAnyNumberOfThreads) {
  const Words words = {"table1", "--objects", "plunger", "--orientations", "1", "--places", "2", "--threads"};
  Words first = words, again = words;
  first.insert(first.end(), {"2", "-o", "out"});
  again.insert(again.end(), {"1", "--csv", "again.csv"});
  const Outcome done = experiment(first);
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.err, "");
  EXPECT_NE(done.out.find("Plunger"), std::string::npos);
  EXPECT_NE(done.out.find("11/12"), std::string::npos) << done.out;  // the paper's
  EXPECT_NE(done.out.find("slot 2"), std::string::npos) << done.out;
  const Json json = Json::parse(folder_.read("out/table1.json"));
  EXPECT_EQ(json["trials"], 2);
  ASSERT_EQ(json["objects"].size(), 1u);
  const Json& plunger = json["objects"][0];
  EXPECT_EQ(plunger["name"], "plunger");
  EXPECT_EQ(plunger["trials"], 2);
  for (const char* attempt : {"first", "second", "third"}) EXPECT_EQ(json[attempt], plunger[attempt]);
  EXPECT_LE(json["first"], json["second"]);
  EXPECT_LE(json["second"], json["third"]);
  // The physics is not a formality, but a plunger is easy.
  EXPECT_EQ(json["third"], 2);
  EXPECT_EQ(experiment(again).out, done.out);
  EXPECT_EQ(folder_.read("again.csv"), folder_.read("out/table1.csv"));
  const std::vector<std::string> csv = lines("out/table1.csv");
  ASSERT_GE(csv.size(), 3u);
  EXPECT_EQ(csv[1].rfind("single_plunger_o1_p1,1,plunger,2,hard,", 0), 0u) << csv[1];
}

TEST_F(Grasping, Table2OfOneTable) {
  const Outcome done = experiment({"table2", "--runs", "1", "--json", "-"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const Json json = Json::parse(done.out);
  EXPECT_EQ(json["of"], 5);
  EXPECT_EQ(json["runs"].size(), 1u);
  EXPECT_GE(json["grasped"], 3);
  EXPECT_GE(json["attempts"], json["grasped"]);
  EXPECT_NE(done.err.find("paper: 46 of 50"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("–"), std::string::npos) << done.err;
}

TEST_F(Grasping, WrongUse) {
  expect_refusal({"table1", "--objects", "mug"}, 2, {"--objects", "'mug'", "plunger"});
  expect_refusal({"table1", "--objects", ","}, 2, {"--objects", "plunger"});
  expect_refusal({"table1", "--orientations", "5"}, 2, {"--orientations = '5'", "1 to 4"});
  expect_refusal({"table1", "--places", "0"}, 2, {"--places = '0'", "1 to 3"});
  expect_refusal({"table2", "--runs", "0"}, 2, {"--runs = '0'"});
  expect_refusal({"table2", "--csv", "no/such/folder.csv"}, 1, {"'no/such/folder.csv'"});
  for (const char* name : {"table1", "table2"}) {
    expect_refusal({name, "--run", "2"}, 2, {"unknown option '--run'", "did you mean '--runs'"});
    expect_refusal({name, "--seed", "-1"}, 2, {"--seed", "whole number"});
    expect_refusal({name, "--threads", "many"}, 2, {"--threads = 'many'"});
  }
  expect_refusal({"table2", "more"}, 2, {"'more'"});
}

}  // namespace
}  // namespace handhold::test
