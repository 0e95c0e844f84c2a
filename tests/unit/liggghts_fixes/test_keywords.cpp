// The table of keywords: each row's parser against its printer.
// What would pass falsely without it: a row that prints another member than it reads, or a word of its list for another
// value, would show wrong settings in the scene report and in the record of a file, which no run depends on; a row
// without a default or without a line of text.
#include <gtest/gtest.h>

#include <map>

#include "coupling/methods.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/script/models.h"
#include "liggghts_fixes/script/script_parser.h"

namespace twogrid {
namespace {

Script fix(const std::string& line = "fine 8 4 16 ratio 4 2 4 density 1.2 viscosity 1.8e-5 every 10") {
  return parse_fix("gas", split(line));
}

std::map<std::string, std::string> texts(const Script& script) {
  std::map<std::string, std::string> all;
  for (const auto& [keyword, value] : settings_texts(script)) all[keyword] = value;
  return all;
}

/// The script that these rows print.
std::string printed(const std::vector<Keyword>& rows, const Script& script) {
  std::string s;
  for (const Keyword& k : rows) {
    if (!k.value) continue;
    std::string value = k.value(script);
    for (std::size_t end; k.parts && (end = value.find("; ")) != std::string::npos; value = value.substr(end + 2))
      s += " " + k.words + " " + value.substr(0, end);
    if (!value.empty()) s += " " + k.words + " " + value;
  }
  return s;
}

TEST(Keywords, WhatRowsPrintIsReadBackAsTheSame) {
  const std::vector<std::pair<std::string, std::string>> scripts{
      {"fine 8 4 16 ratio 4 2 4 density 1.2 viscosity 1.8e-5 every 10", ""},
      {"fine 10 20 30 ratio 5 4 3 domain 0 1 2 4 3 6.1 stretch x 1.1 stretch z symmetric 0.9 density 2 viscosity 3 "
       "every auto",
       "drag kochhill formulation A method jets deposit exact prolong linear read kernel 0.002 eps bound clip 0.35 "
       "interpolate linear hold off one-way yes initial u 1 2 3 initial vortex 0.1 cfl 0.7 dt 1e-4 convection central "
       "implicit on gap friction on pressure_gradient 0 0 -5 flow_rate x 0.2 flow_rate y 0.1 tolerance 1e-8 "
       "accuracy 0.01 output every 20 file bed.h5 fields u eps particles no average from 0.5 overwrite yes legs many "
       "boundary zlo inlet 0 v_U 0.1234567890123456 boundary zlo patch jet rect 0 0.1 0 0.2 inlet 0 0 5 profile "
       "parabolic xy boundary zlo patch plate circle 0 1 2 noslip boundary zlo patch hole region R pressure 3 boundary "
       "xlo noslip 0 v_V 0 boundary zhi pressure -2 boundary ylo periodic"},
      {"fine 8 8 8 density 1 viscosity 1 every 1", "method cube 0.003 read fine"},
      {"fine 8 8 8 density 1 viscosity 1 every 1", "deposit cube 0.003 read cube 0.003 convection none hold on"}};
  for (const auto& [words, more] : scripts) {
    Script script = fix(words);
    if (!more.empty()) parse_fix_modify(script, split(more), false);
    Script again = fix(printed(fix_keywords(), script));
    parse_fix_modify(again, split(printed(fix_modify_keywords(), script)), false);
    EXPECT_EQ(texts(script), texts(again)) << words << "\n" << more;
    for (const auto& [keyword, value] : texts(again)) EXPECT_FALSE(value.empty()) << keyword;
  }
}

// The row shows it, and no other row changes (but those that a method sets).
TEST(Keywords, EachRowPrintsWhatTheScriptGave) {
  const std::vector<std::pair<std::string, std::string>> given{
      {"drag", "kochhill"},
      {"formulation", "A"},
      {"method", "kernel 0.004"},
      {"deposit", "cube 0.003"},
      {"prolong", "linear"},
      {"read", "fine/trilinear"},
      {"eps bound", "clip 0.35"},
      {"interpolate", "linear"},
      {"hold", "off"},
      {"one-way", "yes"},
      {"boundary", "xlo noslip"},
      {"solid", "vessel mesh cad slip fluid_at 0.1 0.2 0.3"},
      {"initial u", "1 2 3"},
      {"initial vortex", "0.1"},
      {"pressure_gradient", "0 0 -5"},
      {"flow_rate", "y 0.2"},
      {"cfl", "0.7"},
      {"dt", "0.0001"},
      {"accuracy", "0.02"},
      {"tolerance", "1e-08"},
      {"convection", "central"},
      {"implicit", "on"},
      {"gap friction", "on"},
      {"output", "every 20 file a.h5 particles yes overwrite no legs one"},
      {"checkpoint", "read a.h5"},
      {"most_lost", "7"}};
  for (const auto& [keyword, value] : given) {
    Script script = fix();
    const auto before = texts(script);
    parse_fix_modify(script, split(keyword + " " + value), false);
    const auto after = texts(script);
    EXPECT_NE(before.at(keyword), value) << keyword;
    EXPECT_EQ(after.at(keyword), value);
    for (const auto& [other, text] : after)
      EXPECT_TRUE(keyword == "method" || other == keyword || text == before.at(other)) << keyword << ": " << other;
  }
  std::size_t printed_rows = 0;
  for (const Keyword& k : fix_modify_keywords()) printed_rows += k.value != nullptr;
  for (const Model& m : models())  // those of a model are for its own test, but for the first
    if (m.name != "gap")
      for (const Keyword& k : m.keywords) printed_rows -= k.value != nullptr;
  EXPECT_EQ(given.size(), printed_rows) << "a row that this test doesn't know";
}

TEST(Keywords, NumbersArePrintedToTheLastBit) {
  for (double x : {0.1, 1.0 / 3, 0.1 + 0.2, 1e-300, 6.02e23, -1.8e-5}) EXPECT_EQ(std::stod(exact(x)), x) << exact(x);
  EXPECT_EQ(exact(1.8e-5), "1.8e-05");
}

TEST(Keywords, PageHasALineForEachRow) {
  const std::string page = keyword_page();
  for (const auto* rows : {&fix_keywords(), &fix_modify_keywords()})
    for (const Keyword& k : *rows) {
      EXPECT_NE(page.find("\n| `" + k.words + "` | "), std::string::npos) << k.words;
      EXPECT_FALSE(default_text(k).empty()) << k.words;
      EXPECT_FALSE(k.values.empty()) << k.words;
    }
  for (const std::string& name : split(method_names()))
    EXPECT_NE(page.find("\n| `" + name + "` | "), std::string::npos);
}

TEST(Models, KeywordsOfAModelMayFollowItsName) {
  Script s = fix();
  parse_fix_modify(s, split("model gap friction on cfl 0.3"), false);
  EXPECT_TRUE(s.settings.fluid.gap_friction);
  EXPECT_EQ(s.settings.fluid.cfl, 0.3);
  const auto sentence = [&](const std::string& words, bool started = false) {
    try {
      parse_fix_modify(s, split(words), started);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  for (const Model& m : models()) EXPECT_NE(sentence("model nothing on").find(m.name), std::string::npos);
  EXPECT_NE(sentence("model").find("end of the line"), std::string::npos);
  EXPECT_NE(sentence("model gap").find("wanted friction"), std::string::npos);
  EXPECT_NE(sentence("model gap width 3").find("width, wanted friction"), std::string::npos);
  EXPECT_NE(sentence("model gap friction maybe").find("model gap friction: found maybe"), std::string::npos);
  EXPECT_NE(sentence("model gap friction off", true).find("first run"), std::string::npos);
}

}  // namespace
}  // namespace twogrid
