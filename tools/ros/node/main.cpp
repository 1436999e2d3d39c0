// handhold_node: handles in the clouds of a topic.
#include <ros/names.h>
#include <ros/ros.h>

#include <string>
#include <vector>

#include "node.h"

namespace {

/// ros::init throws for a name that is none ("cloud:=/my camera"). Such a remapping is left out and described.
std::vector<std::string> remove_bad_names(int& argc, char** argv) {
  std::vector<std::string> problems;
  int kept = 1;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::size_t at = word.find(":=");
    std::string why;
    // "_name:=value" is a parameter, "__name:=value" for ROS itself.
    if (at == std::string::npos || word[0] == '_' ||
        (ros::names::validate(word.substr(0, at), why) && ros::names::validate(word.substr(at + 2), why))) {
      argv[kept++] = argv[i];
    } else {
      problems.push_back("'" + word + "' is no remapping and was left out: " + why);
    }
  }
  argc = kept;
  argv[kept] = nullptr;
  return problems;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> problems = remove_bad_names(argc, argv);
  ros::init(argc, argv, "handhold");
  for (const std::string& problem : problems) ROS_ERROR("%s", problem.c_str());
  handhold::ros_bridge::Node node;
  ros::AsyncSpinner spinner(2);
  spinner.start();
  ros::waitForShutdown();
  return 0;
}
