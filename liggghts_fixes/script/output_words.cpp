#include "liggghts_fixes/script/output_words.h"

#include <algorithm>
#include <string>
#include <vector>

#include "coupling/output/output.h"
#include "liggghts_fixes/script/models.h"

namespace twogrid {
namespace {

std::string average_text(const OutputSettings& out) {
  if (out.average_from < 0) return "";
  return "average from " + (out.average_auto ? "auto" : exact(out.average_from)) +
         (out.until > 0 ? " until " + exact(out.until) : "");
}

}  // namespace

void parse_output(OutputSettings& out, Words& words, bool started) {
  if (words.take_if("off")) {
    if (!started) out = OutputSettings{};
    out.every = 0, out.off = started;
    return;
  }
  static const std::vector<std::string> kFields = [] {
    std::vector<std::string> names = output_fields();
    for (const Model& m : models()) names.insert(names.end(), m.fields.begin(), m.fields.end());
    return names;
  }();
  bool any = false;
  for (;; any = true) {
    if (words.take_if("every")) {
      out.every = words.whole("output every", "a whole number of DEM steps, at least 1", 1);
      out.off = false;
      if (started && out.file.empty())
        refuse("output every", "it after the first run, and no file", "a file, before the first run");
    } else if (!started && words.take_if("file")) {
      out.file = words.name("output file", "a file name");
    } else if (!started && words.take_if("fields")) {
      out.fields.clear();
      while (std::find(kFields.begin(), kFields.end(), words.peek()) != kFields.end())
        out.fields.push_back(words.word("output fields", ""));
      if (out.fields.empty()) refuse("output fields", words.peek(), listed(kFields));
    } else if (!started && words.take_if("particles")) {
      out.particles = words.yes_or_no("output particles");
    } else if (!started && words.take_if("overwrite")) {
      out.overwrite = words.yes_or_no("output overwrite");
    } else if (!started && words.take_if("legs")) {
      out.many_legs = words.one_of("output legs", {"one", "many"}) == 1;
    } else if (words.take_if("average")) {
      if (started && out.average_from < 0)
        refuse("output average", "it after the first run, before which there were no means",
               "means from the first run on: 'output average from' before it, which may change later");
      if (started) ++out.average_said;
      words.one_of("output average", {"from"});
      out.average_auto = words.take_if("auto");
      out.average_from =
          out.average_auto ? 0 : words.number("output average from", "a time in s, at least 0, or auto", kTimes);
      out.until = 0;
      if (words.take_if("until"))
        out.until = words.number("output average until", "a relative standard error above 0, such as 0.02", kErrors);
    } else {
      break;
    }
  }
  if (!any)
    refuse("output", words.peek(),
           started ? "off, every N or average from T|auto [until X] (the rest is fixed at the first run)"
                   : "every N file F [fields u p eps] [particles yes|no] [average from T|auto [until X]] [overwrite "
                     "yes|no] "
                     "[legs one|many], or off");
}

std::string output_text(const OutputSettings& out) {
  if (out.every == 0) return "";
  std::string s = "every " + std::to_string(out.every);
  if (!out.file.empty()) s += " file " + out.file;
  if (!out.fields.empty()) s += " fields";
  for (const std::string& f : out.fields) s += " " + f;
  s += out.particles ? " particles yes" : " particles no";
  if (out.average_from >= 0) s += " " + average_text(out);
  s += out.overwrite ? " overwrite yes" : " overwrite no";
  s += out.many_legs ? " legs many" : " legs one";
  return s;
}

std::string dropped_output(const OutputSettings& before, const OutputSettings& now) {
  std::string dropped;
  if (!before.file.empty() && now.file != before.file && !now.file.empty())
    dropped = "the file " + before.file + ", in place of which " + now.file + " is written: a fix writes one";
  if (before.average_from >= 0 && now.average_from >= 0 && average_text(before) != average_text(now))
    dropped += std::string(dropped.empty() ? "" : "; and ") + "'" + average_text(before) + "', in place of which '" +
               average_text(now) + "' holds";
  return dropped.empty() ? "" : "output: of what was said before, a later line has dropped " + dropped;
}

}  // namespace twogrid
