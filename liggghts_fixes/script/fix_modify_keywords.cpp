#include <algorithm>
#include <cmath>

#include "coupling/forces/drag.h"
#include "coupling/methods.h"
#include "liggghts_fixes/script/boundary_words.h"
#include "liggghts_fixes/script/keywords.h"
#include "liggghts_fixes/script/models.h"
#include "liggghts_fixes/script/options.h"
#include "liggghts_fixes/script/output_words.h"

namespace twogrid {
namespace {

const Options<Formulation> kFormulations{{Formulation::kA, "A"}, {Formulation::kB, "B"}};
const Options<bool> kNoOrYes{{false, "no"}, {true, "yes"}};
const Options<Choice> kChoices{{Choice::kOff, "off"}, {Choice::kOn, "on"}, {Choice::kAuto, "auto"}};
const Options<Deposit> kDeposits{{Deposit::kCentroid, "centroid"},
                                 {Deposit::kTrilinear, "trilinear"},
                                 {Deposit::kExact, "exact", "volume of sphere and cell in common"},
                                 {Deposit::kCube, "cube", "", "EDGE"}};
const Options<Prolong> kProlongs{{Prolong::kConstant, "constant"},
                                 {Prolong::kLinear, "linear", "bounded, volume kept"}};
const Options<Read> kReads{{Read::kCell, "cell", "mean of the particle cell"},
                           {Read::kTrilinear, "trilinear", "between particle cells"},
                           {Read::kFine, "fine"},
                           {Read::kFineTrilinear, "fine/trilinear", "between fine cells"},
                           {Read::kKernel, "kernel", "on the fine grid", "WIDTH"},
                           {Read::kCube, "cube", "", "EDGE"}};
const Options<EpsBound> kBounds{{EpsBound::kMove, "move", "what is too much goes to cells beside"},
                                {EpsBound::kClip, "clip", "it is thrown away"}};
const Options<Interpolate> kInterpolates{{Interpolate::kSmooth, "smooth"}, {Interpolate::kLinear, "linear"}};
const Options<Convection> kConvections{
    {Convection::kVanLeer, "vanleer", "bounded"},
    {Convection::kCentral, "central",
     "keeps energy, not bounded: for verification and finely resolved flows; unstable above a Courant number of 0.6: "
     "`tests/run.sh -R verification_np1`"},
    {Convection::kNone, "none"}};

/// A row for one choice out of a list. member(settings): where it goes.
template <class E, class Member>
Keyword choice(const std::string& words, const Options<E>& options, const std::string& text, const std::string& line,
               Member member) {
  return {words,
          option_list(options),
          "",
          text,
          "",
          line,
          [&options, member](const Line& l) { member(l.settings()) = take_option(l.words, l.keyword, options); },
          [&options, member](const Script& script) {
            Settings s = script.settings;
            return std::string(option_of(options, member(s)).word);
          }};
}

std::string three(const Vec3& v) {
  return exact(v[0]) + " " + exact(v[1]) + " " + exact(v[2]);
}
Vec3 three_numbers(const Line& line, const std::string& wanted, const Range& range) {
  Vec3 v;
  for (double& x : v) x = line.number(wanted, range);
  return v;
}

std::string in_quotes(const std::string& names) {
  std::string s;
  for (const std::string& name : split(names)) s += (s.empty() ? "`" : ", `") + name + "`";
  return s;
}

// ---- drag, method, deposit, read, eps bound ------------------------------------------------------------------------

void parse_drag(const Line& line) {
  const std::string wanted = "one of " + drag_law_names();
  line.settings().drag = line.words.word(line.keyword, wanted);
  if (!find_drag_law(line.settings().drag)) refuse(line.keyword, line.settings().drag, wanted);
}

void parse_method(const Line& line) {
  const std::string wanted = "one of " + method_names(), name = line.words.word(line.keyword, wanted);
  const Method* method = find_method(name);
  if (!method) refuse(line.keyword, name, wanted);
  const double length =
      method->length ? line.words.number("method " + name, std::string("a ") + method->length, kLengths) : 0.0;
  choose(*method, length, line.settings());
}

std::string method_list() {
  std::string s;
  for (const std::string& name : split(method_names())) {
    const Method& m = *find_method(name);
    s += (s.empty() ? "`" : ", `") + name + "`" +
         (!m.length                 ? ""
          : m.read == Read::kKernel ? " WIDTH (m)"
                                    : " EDGE (m)");
  }
  return s;
}

std::string length_text(const Settings& s, Deposit deposit, Read read) {
  if (read == Read::kKernel) return " " + exact(s.kernel_width);
  if (read == Read::kCube || deposit == Deposit::kCube) return " " + exact(s.cube_edge);
  return "";
}

std::string method_text(const Script& script) {
  const Settings& s = script.settings;
  const Method& m = *find_method(s.method);
  return s.method + (m.length ? length_text(s, m.deposit, m.read) : "");
}

void parse_deposit(const Line& line) {
  Settings& s = line.settings();
  s.deposit = take_option(line.words, line.keyword, kDeposits);
  if (s.deposit == Deposit::kCube) s.cube_edge = line.words.number("deposit cube", "an edge above 0 (m)", kLengths);
}

void parse_read(const Line& line) {
  Settings& s = line.settings();
  s.read = take_option(line.words, line.keyword, kReads);
  if (s.read == Read::kKernel) s.kernel_width = line.words.number("read kernel", "a full width above 0 (m)", kLengths);
  if (s.read != Read::kCube) return;
  const double edge = line.words.number("read cube", "an edge above 0 (m)", kLengths);
  if (s.deposit == Deposit::kCube && s.cube_edge != edge)
    refuse("read cube", text(edge), "the edge of deposit cube, " + text(s.cube_edge));
  s.cube_edge = edge;
}

void parse_eps_bound(const Line& line) {
  Settings& s = line.settings();
  s.bound = take_option(line.words, line.keyword, kBounds);
  s.eps_min = line.number("a smallest void fraction between 0 and 1", kVoidFractions);
}

// ---- checkpoint ----------------------------------------------------------------------------------------------------

void parse_checkpoint_times(const Line& line, CheckpointPlan& plan) {
  const std::string wanted = "a number of DEM steps, or a time as in 'every 30 min' or 'every 2 h'";
  const std::string found = line.words.peek();
  const double number = line.words.number("checkpoint every", wanted, {0, 1e15});
  const std::string unit = line.words.peek();
  plan.every = 0, plan.seconds = 0;
  if (line.words.take_if("min") || line.words.take_if("h")) {
    plan.seconds = (unit == "h" ? 3600 : 60) * number;
    if (!(plan.seconds >= kCheckpointTimes.least && plan.seconds <= kCheckpointTimes.most))
      refuse("checkpoint every", found + " " + unit,
             "a time of " + text(kCheckpointTimes.least) + " to " + text(kCheckpointTimes.most) + " s");
  } else {
    if (number != std::floor(number) || number < 1) refuse("checkpoint every", found, wanted);
    plan.every = (long long)(number);
  }
}

void parse_one_of_checkpoint(const Line& line) {
  CheckpointPlan& plan = line.script.checkpoints;
  switch (line.words.one_of("checkpoint", {"write", "read", "every", "folder", "keep"})) {
    case 0:
      line.script.checkpoint_write = line.words.name("checkpoint write", "a file name");
      break;
    case 1:
      if (line.started)
        refuse("checkpoint read", "it after a run with this fix", "it before the first run, after read_restart");
      line.script.checkpoint_read = line.words.name("checkpoint read", "a file name");
      break;
    case 2:
      parse_checkpoint_times(line, plan);
      break;
    case 3:
      plan.folder = line.words.name("checkpoint folder", "a folder's name");
      break;
    default:
      plan.keep = line.words.whole("checkpoint keep", "a number of checkpoints, at least 1", 1);
  }
}

void parse_checkpoint(const Line& line) {
  parse_one_of_checkpoint(line);
  while (line.words.next_is("every") || line.words.next_is("folder") || line.words.next_is("keep"))
    parse_one_of_checkpoint(line);
}

std::string checkpoint_text(const Script& script) {
  const CheckpointPlan& plan = script.checkpoints;
  std::string s = script.checkpoint_read.empty() ? "" : "read " + script.checkpoint_read;
  if (plan.every > 0) s += " every " + std::to_string(plan.every);
  if (plan.seconds > 0) s += " every " + exact(plan.seconds / 60) + " min";
  if (!plan.folder.empty()) s += " folder " + plan.folder;
  if (plan.by_itself()) s += " keep " + std::to_string(plan.keep);
  return s.empty() || s[0] != ' ' ? s : s.substr(1);
}

void parse_most_lost(const Line& line) {
  line.script.most_lost =
      line.words.take_if("off") ? -1 : line.words.whole(line.keyword, "a number of particles, at least 0, or off", 0);
}

// ---- bodies --------------------------------------------------------------------------------------------------------

const Options<BodyNames::Kind> kBodies{
    {BodyNames::Kind::kMesh, "mesh"}, {BodyNames::Kind::kWall, "wall"}, {BodyNames::Kind::kRegion, "region"}};

void parse_blow(Words& words, const std::string& keyword, BodyNames& body) {
  words.word("", "");
  const std::string what = keyword + " blow";
  const std::string wanted = "a velocity in m/s, a number or v_NAME, of gas that enters through the surface";
  body.blows = true;
  if (const std::string& next = words.peek(); next.rfind("v_", 0) == 0 && next.size() > 2)
    body.blow_variable = words.name(what, wanted).substr(2);
  else
    body.blow = words.number(what, wanted + ", not below 0 (what leaves needs a side with 'pressure 0')",
                             {0, kVelocities.most});
  if (!words.take_if("from")) return;
  words.one_of(what + " from", {"region"});
  body.blow_region = words.name(what + " from region", "the id of a region that holds the part that blows");
}

void parse_solid(const Line& line) {
  Words& words = line.words;
  BodyNames body;
  body.name = words.name("solid", "a name for the body, then mesh FIXID, wall FIXID or region ID");
  const std::string keyword = "solid " + body.name;
  for (const BodyNames& other : line.script.bodies)
    if (other.name == body.name) refuse(keyword, "a second body of this name", "a name of its own for each body");
  body.kind = take_option(words, keyword, kBodies);
  const std::string kind = option_of(kBodies, body.kind).word;
  body.id = words.name(keyword + " " + kind,
                       body.kind == BodyNames::Kind::kRegion ? "the id of a region" : "the id of a fix");
  bool slip_given = false;
  for (;;) {
    const bool slip = words.next_is("slip");
    if (slip || words.next_is("noslip")) {
      if (slip_given) refuse(keyword, "noslip and slip, or one of them twice", "one of them");
      slip_given = true, body.slip = slip;
      words.word("", "");
    } else if (words.take_if("sheet")) {
      if (body.kind != BodyNames::Kind::kMesh)
        refuse(keyword, kind + " " + body.id + " as a sheet", "a mesh: 'solid " + body.name + " mesh FIXID sheet'");
      body.sheet = true;
    } else if (words.next_is("blow")) {
      if (body.blows) refuse(keyword, "blow twice", "it once");
      parse_blow(words, keyword, body);
    } else if (words.take_if("fluid_at")) {
      Vec3 x;
      for (double& c : x)
        c = words.number(keyword + " fluid_at", "three coordinates in m of a point in the fluid", kCoordinates);
      body.fluid_at.push_back(x);
    } else {
      break;
    }
  }
  if (body.blows && body.sheet)
    refuse(keyword + " blow", "a sheet, which has fluid on both sides",
           "a mesh with an inside, two cells thick at least, without the word sheet");
  line.script.bodies.push_back(body);
}

std::string solid_text(const Script& script) {
  std::string s;
  for (const BodyNames& b : script.bodies) {
    s += (s.empty() ? "" : "; ") + b.name + " " + option_of(kBodies, b.kind).word + " " + b.id +
         (b.sheet ? " sheet" : "") + (b.slip ? " slip" : " noslip");
    if (b.blows) s += " blow " + (b.blow_variable.empty() ? exact(b.blow) : "v_" + b.blow_variable);
    if (!b.blow_region.empty()) s += " from region " + b.blow_region;
    for (const Vec3& x : b.fluid_at) s += " fluid_at " + three(x);
  }
  return s;
}

// ---- flow and steps ------------------------------------------------------------------------------------------------

void parse_flow_rate(const Line& line) {
  const int d = line.words.one_of(line.keyword, {"x", "y", "z"});
  line.fluid().flow_rate[d] = line.number("a mean superficial velocity in m/s", kVelocities);
  line.fluid().flow_rate_set[d] = true;
}

std::string flow_rate_text(const Script& script) {
  const FluidSettings& f = script.settings.fluid;
  std::string s;
  for (int d = 0; d < 3; ++d)
    if (f.flow_rate_set[d]) s += (s.empty() ? "" : "; ") + std::string(1, "xyz"[d]) + " " + exact(f.flow_rate[d]);
  return s;
}

void parse_accuracy(const Line& line) {
  line.settings().accuracy = line.number("a relative error of the steps in time", {1e-4, 0.5});
}

void parse_cfl(const Line& line) {
  line.settings().cfl_given = true;
  line.fluid().cfl = line.number("a Courant number above 0 and at most 1", kCourantNumbers);
}

void parse_tolerance(const Line& line) {
  line.settings().tolerance_given = true;
  line.fluid().pressure_rtol = line.number("a relative continuity error above 0 and at most 0.1", kTolerances);
}

/// A number that is not set while it is 0.
std::string unless_0(double value) {
  return value == 0 ? "" : exact(value);
}

std::vector<Keyword> make_rows() {
  std::vector<Keyword> rows{
      {"drag", in_quotes(drag_law_names()), "", "", "", "", parse_drag,
       [](const Script& s) { return s.settings.drag; }},
      choice("formulation", kFormulations, "form of the equations, see below", "",
             [](Settings& s) -> Formulation& { return s.formulation; }),
      {"method", method_list(), "", "sets deposit, prolong and read, table below; each may be changed after it", "",
       "method", parse_method, method_text},
      {"deposit", option_list(kDeposits), "", "how a particle's volume goes onto the particle cells", "", "method",
       parse_deposit,
       [](const Script& s) {
         return option_of(kDeposits, s.settings.deposit).word +
                length_text(s.settings, s.settings.deposit, Read::kCell);
       },
       [](const Script& s) { return option_of(kDeposits, s.settings.deposit).note; }},
      choice("prolong", kProlongs, "how the void fraction comes down to the fine cells", "method",
             [](Settings& s) -> Prolong& { return s.prolong; }),
      {"read", option_list(kReads), "", "what of the fluid a particle feels", "", "method", parse_read,
       [](const Script& s) {
         return option_of(kReads, s.settings.read).word + length_text(s.settings, Deposit::kCentroid, s.settings.read);
       },
       [](const Script& s) { return option_of(kReads, s.settings.read).note; }},
      {"eps bound", option_list(kBounds) + ", then EPS", "", "smallest void fraction of a particle cell", "", "method",
       parse_eps_bound,
       [](const Script& s) { return option_of(kBounds, s.settings.bound).word + (" " + exact(s.settings.eps_min)); }},
      choice("interpolate", kInterpolates, "void fraction between couplings, seen by sub-steps of the fluid",
             "numerics", [](Settings& s) -> Interpolate& { return s.interpolate; }),
      choice("hold", kChoices, "between couplings particles see the volume flux held, not the velocity", "numerics",
             [](Settings& s) -> Choice& { return s.hold_flux; }),
      choice("one-way", kNoOrYes, "the fluid doesn't feel the particles", "",
             [](Settings& s) -> bool& { return s.one_way; }),
      {"boundary", "SIDE condition, or SIDE `patch` NAME shape condition", "", "see below",
       "`slip`, or periodic where the box is", "", [](const Line& l) { parse_boundary(l.script, l.words, l.started); },
       boundary_text, nullptr, true, true},
      {"solid",
       "NAME, then `mesh` FIXID, `wall` FIXID or `region` ID, then perhaps `noslip` or `slip`, `sheet`, `fluid_at` x y "
       "z (m), `blow` U (gas through its surface, m/s; a number or `v_NAME`) and perhaps `from region` ID",
       "", "a vessel or body that is solid for the fluid, see Vessels and bodies; several", "none; noslip", "",
       parse_solid, solid_text, nullptr, true},
      {"initial u", "ux uy uz", "m/s", "interstitial velocity at the beginning", "", "flow",
       [](const Line& l) { l.fluid().initial_velocity = three_numbers(l, "three velocities in m/s", kVelocities); },
       [](const Script& s) { return three(s.settings.fluid.initial_velocity); }},
      {"initial vortex", "U", "m/s", "Taylor-Green vortices in x and y over the domain, on top of `initial u`", "",
       "flow", [](const Line& l) { l.fluid().initial_vortex = l.number("a velocity in m/s", kVelocities); },
       [](const Script& s) { return exact(s.settings.fluid.initial_vortex); }},
      {"pressure_gradient", "px py pz", "Pa/m", "of the mean pressure, in periodic directions", "", "flow",
       [](const Line& l) {
         l.fluid().pressure_gradient = three_numbers(l, "three gradients in Pa/m", kPressureGradients);
       },
       [](const Script& s) { return three(s.settings.fluid.pressure_gradient); }},
      {"flow_rate", "`x`, `y` or `z`, and the mean of eps u + eps_s v", "m/s", "in a periodic direction", "none",
       "flow", parse_flow_rate, flow_rate_text, nullptr, true},
      {"cfl", "X", "", "largest Courant number of a fluid step, up to 1 (0.6 with `convection central`)", "",
       "numerics", parse_cfl, [](const Script& s) { return exact(s.settings.fluid.cfl); }},
      {"dt", "X", "s", "largest fluid step; `cfl` is then not looked at", "as cfl and the coupling interval allow",
       "numerics", [](const Line& l) { l.fluid().dt = l.number("a largest fluid step above 0 (s)", kFluidSteps); },
       [](const Script& s) { return unless_0(s.settings.fluid.dt); }},
      {"accuracy", "X, such as 0.01", "",
       "error wanted of the steps in time. Chooses cfl and solver tolerance (and the coupling interval with `every "
       "auto`), checks itself now and then against half the step",
       "off", "", parse_accuracy, [](const Script& s) { return unless_0(s.settings.accuracy); }},
      {"tolerance", "X", "", "continuity error wanted, relative to U/h", "", "numerics", parse_tolerance,
       [](const Script& s) { return exact(s.settings.fluid.pressure_rtol); }},
      choice("convection", kConvections, "how the flow carries momentum", "numerics",
             [](Settings& s) -> Convection& { return s.fluid.convection; }),
      choice("implicit", kChoices, "viscosity treated implicitly", "numerics",
             [](Settings& s) -> Choice& { return s.fluid.implicit_viscosity; }),
      {"output",
       "`every` N DEM steps, `file` NAME.h5, `fields` some of `u p eps faces walls`, `particles yes` or `no`, `average "
       "from` T (s of fluid time) or `auto`: from the end of start-up on, which the run finds; `until` X: the run ends "
       "when "
       "the means' relative standard error is X (said after the first run: the means begin anew); `overwrite no` or "
       "`yes`: replace a file that is there, `legs one` or "
       "`many`: a file for each restart; or `off`",
       "", "", "none", "", [](const Line& l) { parse_output(l.settings().output, l.words, l.started); },
       [](const Script& s) { return output_text(s.settings.output); }, nullptr, false, true},
      {"checkpoint",
       "`every` N (DEM steps), T `min` or T `h`, `folder` NAME, `keep` K; or `write` FILE, between runs, or `read` "
       "FILE, "
       "before the first",
       "", "all that a run needs to go on, see Restart", "none; K 2", "", parse_checkpoint, checkpoint_text, nullptr,
       false, true},
      {"most_lost", "N, or `off`", "", "a run ends when more than N particles have vanished from it", "off", "",
       parse_most_lost, [](const Script& s) { return s.most_lost < 0 ? "" : std::to_string(s.most_lost); }, nullptr,
       false, true},
      {"model", "NAME keyword value ...", "", "", "none", "", parse_model, nullptr, nullptr, false, true}};
  std::vector<std::string> names;
  for (const Model& m : models()) {
    names.push_back("`" + m.name + "`");
    rows.insert(rows.end(), m.keywords.begin(), m.keywords.end());
  }
  for (Keyword& k : rows)
    if (k.words == "model") k.text = "keywords of a model, whose name they begin with: " + listed(names);
  return rows;
}

}  // namespace

const std::vector<Keyword>& fix_modify_keywords() {
  static const std::vector<Keyword> kRows = make_rows();
  return kRows;
}

}  // namespace twogrid
