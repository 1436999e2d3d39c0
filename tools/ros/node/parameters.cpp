#include "parameters.h"

#include <ros/param.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <charconv>
#include <stdexcept>

namespace handhold::ros_bridge {
namespace {

using XmlRpc::XmlRpcValue;

/// @throws std::invalid_argument
std::string text_of(XmlRpcValue& value) {
  switch (value.getType()) {
    case XmlRpcValue::TypeBoolean:
      return static_cast<bool>(value) ? "true" : "false";
    case XmlRpcValue::TypeInt:
      return std::to_string(static_cast<int>(value));
    case XmlRpcValue::TypeDouble: {
      char digits[32];  // bit for bit, whatever the locale
      return {digits, std::to_chars(digits, digits + sizeof digits, static_cast<double>(value)).ptr};
    }
    case XmlRpcValue::TypeString:
      return static_cast<std::string>(value);
    case XmlRpcValue::TypeArray: {
      std::string text;
      for (int i = 0; i < value.size(); ++i) {
        const auto type = value[i].getType();
        if (type != XmlRpcValue::TypeInt && type != XmlRpcValue::TypeDouble) break;
        text += (i ? " " : "") + text_of(value[i]);
        if (i + 1 == value.size()) return text;
      }
      if (value.size() == 0) return text;
      throw std::invalid_argument("is a list with something else than numbers in it; must be numbers only");
    }
    default:
      throw std::invalid_argument(
          "is a group of parameters; must be a number, a text, true or false, or a list of numbers");
  }
}

}  // namespace

Texts server_parameters(const std::string& where, std::vector<std::string>& problems) {
  Texts texts;
  XmlRpcValue all;
  if (!ros::param::get(where, all) || all.getType() != XmlRpcValue::TypeStruct) return texts;
  for (auto& [name, value] : all) {
    try {
      texts[name] = text_of(value);
    } catch (const std::invalid_argument& error) {
      problems.push_back("parameter " + where + "/" + name + " " + error.what());
    }
  }
  return texts;
}

}  // namespace handhold::ros_bridge
