#include "tables.h"

#include <algorithm>

#include "causes.h"
#include "text.h"

namespace handhold::evaluation {
namespace {

constexpr double kDegree = 180 / 3.14159265358979323846;

std::string share(const Share& s) {
  if (s.of == 0) return "    -";
  return format("%.3f", s.value());
}

std::string cell(const std::optional<double>& value, double unit) {
  return value ? format("%7.1f", *value * unit) : "      -";
}

std::string errors(const Errors& e) {
  return cell(e.center, 1000) + cell(e.axis, kDegree) + cell(e.radius, 1000) + cell(e.length, 1000);
}

std::string groups(const std::string& title, const std::vector<Group>& groups, bool precision) {
  if (groups.empty()) return {};
  std::size_t width = title.size();
  for (const Group& group : groups) width = std::max(width, group.name.size());
  const int columns = static_cast<int>(std::min<std::size_t>(width, 44));
  std::string text = format("\n%-*s  recall  found/needed  centre   axis radius length%s\n", columns, title.c_str(),
                            precision ? "  precision  right/handles" : "");
  for (const Group& group : groups) {
    text += format("%-*.*s  %6s  %5zu/%-6zu ", columns, columns, group.name.c_str(), share(group.recall).c_str(),
                   group.recall.count, group.recall.of) +
            errors(group.errors);
    if (precision) {
      text += format("  %9s  %5zu/%zu", share(group.precision).c_str(), group.precision.count, group.precision.of);
    }
    text += "\n";
  }
  return text;
}

std::string false_families(const std::vector<FamilyFalse>& families) {
  if (families.empty()) return {};
  int columns = 16;  // of the title
  for (const FamilyFalse& f : families) columns = std::max(columns, static_cast<int>(f.family.size()));
  std::string text = format("\n%-*s  count  sound  objects without/all\n", columns, "false handles on"), none;
  for (const FamilyFalse& f : families) {
    if (f.sound.of == 0) {
      none += (none.empty() ? "none on " : ", ") + f.family + format(" (%zu)", f.quiet.of);
    } else {
      text += format("%-*s  %5zu  %5zu  %15zu/%zu\n", columns, f.family.c_str(), f.sound.of, f.sound.count,
                     f.quiet.count, f.quiet.of);
    }
  }
  return text + (none.empty() ? "" : none + "\n");
}

const char* name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kRight:
      return "right";
    case Verdict::kDuplicate:
      return "duplicate";
    case Verdict::kFalse:
      return "false";
    case Verdict::kLeftOut:
      return "left_out";
  }
  return "";
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

struct Counts {
  std::size_t needed = 0, found = 0, handles = 0, right = 0, duplicates = 0, wrong = 0;
};

Counts count(const SceneScore& score) {
  Counts c;
  for (const PartCase& part : score.parts) {
    c.needed += part.needed;
    c.found += part.needed && part.handle >= 0;
  }
  for (const HandleCase& handle : score.handles) {
    c.handles += handle.verdict != Verdict::kLeftOut;
    c.right += handle.verdict == Verdict::kRight;
    c.duplicates += handle.verdict == Verdict::kDuplicate;
    c.wrong += handle.verdict == Verdict::kFalse;
  }
  return c;
}

/// Errors as cells of the CSV (m, rad).
std::string error_cells(const HandleCase& h) {
  return format("%.6f,%.6f,%.6f,%.6f", h.offset.across, h.offset.angle, h.offset.radius, h.length_error);
}

std::string object_cells(const SceneObject& object) {
  return quoted(object.name) + "," + quoted(object.family);
}

}  // namespace

std::string summary_text(const Summary& s) {
  const auto line = [](const char* name, const Share& value, const char* what) {
    return format("%-12s %s  %zu of %zu %s\n", name, share(value).c_str(), value.count, value.of, what);
  };
  std::string text = format("%-12s %zu\n", "scenes", s.scenes);
  text += line("recall", s.recall, "needed parts found");
  text += line("precision", s.precision, "handles are the first on a listed part");
  text += line("duplicates", s.duplicates, "handles are on a part already found");
  if (s.quiet.of) text += line("quiet", s.quiet, "scenes without listed parts have no handle");
  if (s.unneeding_quiet.of != s.quiet.of) {
    text += line("quiet too", s.unneeding_quiet, "scenes without needed parts have no false handle");
  }
  if (s.sound_handles.of) {
    text += line("soundness", s.sound_handles, "handles would hold something");
  }
  if (s.sound_affordances.of) text += line("", s.sound_affordances, "affordances would");
  if (s.sound_false_handles.of) {
    const std::size_t unsound = s.sound_false_handles.of - s.sound_false_handles.count;
    text += line("false", s.sound_false_handles, format("false handles are sound, %zu unsound", unsound).c_str());
  }
  text += "median errors of found parts: centre" + cell(s.errors.center, 1000) + " mm, axis" +
          cell(s.errors.axis, kDegree) + " deg, radius" + cell(s.errors.radius, 1000) + " mm, length" +
          cell(s.errors.length, 1000) + " mm\n";
  text += groups("part", s.by_what, false);
  text += groups("radius", s.by_radius, true);
  text += groups("support", s.by_support, false);
  text += false_families(s.false_by_family);
  text += "\nconfidence   handles  right  share  mean confidence\n";
  for (const ConfidenceBin& bin : s.reliability) {
    text += format("%.1f to %.1f  %9zu %6zu  %5s  ", bin.from, bin.to, bin.right.of, bin.right.count,
                   share(bin.right).c_str());
    text += bin.right.of ? format("%.3f\n", bin.mean_confidence) : "-\n";
  }
  text += format("mean distance between confidence and share right: %.3f\n", s.calibration_error);
  return text;
}

std::string cases_text(const std::vector<Scene>& scenes) {
  std::string text;
  for (const Scene& scene : scenes) {
    for (std::size_t k = 0; k < scene.parts.size(); ++k) {
      const PartCase& part = scene.score.parts[k];
      if (!part.needed || part.handle >= 0) continue;
      text += scene.name + ": missed '" + scene.parts[k].what +
              "': " + why_missed(k, scene.parts, scene.result, scene.score) + "\n";
    }
    for (std::size_t i = 0; i < scene.score.handles.size(); ++i) {
      const Verdict verdict = scene.score.handles[i].verdict;
      if (verdict != Verdict::kFalse && verdict != Verdict::kDuplicate) continue;
      text += scene.name + ": " + name(verdict) + format(" handle %zu: ", i + 1) +
              why_false(i, scene.parts, scene.result, scene.score) + "\n";
    }
  }
  return text;
}

std::string csv(const std::vector<Scene>& scenes) {
  std::string text =
      "record,scene,index,what,verdict,confidence,radius_m,length_m,centre_error_m,axis_error_rad,radius_error_m,"
      "length_error_m,sound,object,family,cause,needed,found,handles,right,duplicates,false,affordances,sound_"
      "affordances\n";
  const std::string no_counts = ",,,,,,,,";
  for (const Scene& scene : scenes) {
    const SceneScore& score = scene.score;
    const Counts c = count(score);
    text += "scene," + quoted(scene.name) + ",,,,,,,,,,,,,,," +
            format("%zu,%zu,%zu,%zu,%zu,%zu,%zu,%zu\n", c.needed, c.found, c.handles, c.right, c.duplicates, c.wrong,
                   score.affordances, score.sound_affordances);
    for (std::size_t i = 0; i < score.handles.size(); ++i) {
      const HandleCase& h = score.handles[i];
      const Handle& handle = scene.result.handles[i];
      const bool explained = h.verdict == Verdict::kFalse || h.verdict == Verdict::kDuplicate;
      text += "handle," + quoted(scene.name) + format(",%zu,", i + 1) +
              (h.part < 0 ? "" : quoted(scene.parts[static_cast<std::size_t>(h.part)].what)) + "," + name(h.verdict) +
              format(",%.6f,%.6f,%.6f,", handle.confidence, handle.radius, handle.length) +
              (h.part < 0 ? ",,," : error_cells(h)) + "," + (h.sound ? (*h.sound ? "1" : "0") : "") + "," +
              (h.object < 0 ? "," : object_cells(score.objects[static_cast<std::size_t>(h.object)])) + "," +
              (explained ? quoted(why_false(i, scene.parts, scene.result, score)) : "") + no_counts + "\n";
    }
    for (std::size_t k = 0; k < score.parts.size(); ++k) {
      const PartCase& part = score.parts[k];
      if (!part.needed) continue;
      text += "part," + quoted(scene.name) + format(",%zu,", k + 1) + quoted(scene.parts[k].what) + "," +
              (part.handle < 0 ? "missed" : "found") +
              format(",%.6f,%.6f,%.6f,", scene.parts[k].confidence, scene.parts[k].radius, scene.parts[k].length) +
              (part.handle < 0 ? ",,," : error_cells(score.handles[static_cast<std::size_t>(part.handle)])) + ",,," +
              quoted(scene.parts[k].family) + "," +
              (part.handle < 0 ? quoted(why_missed(k, scene.parts, scene.result, score)) : "") + no_counts + "\n";
    }
  }
  return text;
}

}  // namespace handhold::evaluation
