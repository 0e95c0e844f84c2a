#include "liggghts_fixes/run/interpreter.h"

#include <atom.h>
#include <error.h>
#include <input.h>
#include <lammps.h>
#include <memory.h>
#include <modify.h>
#include <mpi.h>
#include <variable.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "cfd/parallel/rank_0.h"
#include "cfd/parallel/ranks.h"
#include "coupling/checkpoint/checksum.h"
#include "liggghts_fixes/run/old_files.h"
#include "liggghts_fixes/run/still_files.h"

namespace twogrid {

using namespace LAMMPS_NS;

namespace {

constexpr char kRunMade[] = "(run)";

/// What LIGGGHTS' interpreter keeps for itself.
struct Inside : Input {
  static char*& the_command(Input& in) { return in.*&Inside::command; }
  static char*& the_line(Input& in) { return in.*&Inside::line; }
  static char*& the_work(Input& in) { return in.*&Inside::work; }
  static int& the_maxline(Input& in) { return in.*&Inside::maxline; }
  static int& the_maxwork(Input& in) { return in.*&Inside::maxwork; }
  static int& the_maxarg(Input& in) { return in.*&Inside::maxarg; }
  static int& the_label_active(Input& in) { return in.*&Inside::label_active; }
  static int& the_jump_skip(Input& in) { return in.*&Inside::jump_skip; }
  static int& the_nfile(Input& in) { return in.*&Inside::nfile; }
  static int& the_maxfile(Input& in) { return in.*&Inside::maxfile; }
  static FILE**& the_infiles(Input& in) { return in.*&Inside::infiles; }
  static bool echoes(Input& in, bool to_log) {
    return (to_log ? in.*&Inside::echo_log : in.*&Inside::echo_screen) != 0;
  }
  static void parse_line(Input& in) { (in.*&Inside::parse)(); }
  static bool execute(Input& in) { return (in.*&Inside::execute_command)() == 0; }
  static bool has_command(Input& in, const std::string& name) { return (in.*&Inside::command_map)->count(name) > 0; }
  static void set_line(Input& in, const std::string& text) {
    if (int(text.size()) + 1 > the_maxline(in))
      (in.*&Inside::reallocate)(the_line(in), the_maxline(in), int(text.size()) + 1);
    std::memcpy(the_line(in), text.c_str(), text.size() + 1);
  }
  static void substitute_line(Input& in) {
    in.substitute(the_line(in), the_work(in), the_maxline(in), the_maxwork(in), 0);
  }
};

/// The file's bytes up to `at`.
std::string beginning(const std::string& name, long at) {
  std::string text(std::size_t(std::max(0L, at)), '\0');
  std::FILE* f = std::fopen(name.c_str(), "rb");
  if (!f) return "";
  text.resize(std::fread(text.data(), 1, text.size(), f));
  std::fclose(f);
  return text;
}

std::string words_text(const Command& c) {
  std::string s;
  for (const std::string& w : c) s += (s.empty() ? "" : " ") + w;
  return s;
}

}  // namespace

Interpreter::Interpreter(LAMMPS& lammps, std::string script, std::vector<std::vector<std::string>> variables)
    : lammps_(lammps), script_(std::move(script)), variables_(std::move(variables)), names_{script_} {}

void Interpreter::agree(const std::string& sentence) const {
  const std::string s = from_rank(lammps_.world, 0, sentence);
  if (!s.empty()) throw std::invalid_argument(s);
}

void Interpreter::run(const std::function<bool()>& stop) {
  for (std::string line; next_line(line);) {
    execute(line);
    if (quits_ || stop()) return;
  }
}

void Interpreter::one(const std::string& line) {
  const std::size_t before = pending_.size();
  execute(line);
  while (pending_.size() > before) {
    const std::string next = pending_.front();
    pending_.pop_front();
    execute(next);
  }
}

/// A line that ends with & goes on in the next one.
bool Interpreter::next_line(std::string& line) {
  Input& in = *lammps_.input;
  line_.clear();
  if (!pending_.empty()) {
    line = pending_.front();
    pending_.pop_front();
    return true;
  }
  for (;;) {
    int state = 0;  // 1: a line; 0: the innermost file is at its end; -1: so is the script
    if (rank_of(lammps_.world) == 0) {
      FILE*& file = lammps_.infile;
      begin_ = std::ftell(file);
      line.clear();
      for (int c; (c = std::fgetc(file)) != EOF;) {
        state = 1;
        if (c != '\n') {
          line += char(c);
          continue;
        }
        std::size_t end = line.size();
        while (end > 0 && std::isspace(static_cast<unsigned char>(line[end - 1]))) --end;
        line.resize(end);
        if (line.empty() || line.back() != '&') break;
        line.pop_back();
      }
      if (state == 0) {
        if (file != stdin) std::fclose(file);
        names_.pop_back();
        if (--Inside::the_nfile(in) == 0)
          state = -1;
        else
          file = Inside::the_infiles(in)[Inside::the_nfile(in) - 1];
      }
    }
    MPI_Bcast(&state, 1, MPI_INT, 0, lammps_.world);
    if (state == 1) break;
    if (Inside::the_label_active(in)) lammps_.error->all(FLERR, "Label wasn't found in input script");
    if (state == -1) return false;
  }
  line = from_rank(lammps_.world, 0, line);
  line_ = line;
  return true;
}

void Interpreter::execute(const std::string& line) {
  Input& in = *lammps_.input;
  Inside::set_line(in, line);
  if (rank_of(lammps_.world) == 0 && !Inside::the_label_active(in)) {
    if (Inside::echoes(in, false) && lammps_.screen) std::fprintf(lammps_.screen, "%s\n", line.c_str());
    if (Inside::echoes(in, true) && lammps_.logfile) std::fprintf(lammps_.logfile, "%s\n", line.c_str());
  }
  Inside::parse_line(in);
  if (!Inside::the_command(in)) return;
  if (Inside::the_label_active(in) && std::strcmp(Inside::the_command(in), "label") != 0) return;
  execute_parsed();
}

void Interpreter::execute_parsed() {
  Input& in = *lammps_.input;
  const std::string name = Inside::the_command(in);
  if (name == "if") return choose();
  if (name == "quit") return end_script();
  Command command{name};
  command.insert(command.end(), in.arg, in.arg + in.narg);
  if (name == "clear" && command.size() == 1) forget_scene(done_);
  if (files_are_still() && leave_out(command)) return;
  const bool jumps = name == "jump" && !Inside::the_jump_skip(in);
  if (is_said_again(command, Inside::has_command(in, name))) done_.push_back(command);
  if (!Inside::execute(in))
    lammps_.error->all(FLERR, ("Unknown command: " + std::string(Inside::the_line(in))).c_str());
  if (rank_of(lammps_.world) != 0) return;
  if (name == "include") names_.push_back(command.at(1));
  if (jumps && command.at(1) != "SELF") names_.back() = command[1];
}

/// In a script that is only planned: what other programs do, or what changes files.
bool Interpreter::leave_out(const Command& command) const {
  if (command[0] != "shell" || command.size() < 2 || command[1] == "cd" || command[1] == "putenv") return false;
  if (command[1] == "mkdir")
    for (std::size_t i = 2; i < command.size(); ++i) take_as_folder(command[i]);
  else if (command[1] != "rm" && command[1] != "rmdir")
    expect_missing_folders();
  return true;
}

/// `quit` is the script's end like any other: LIGGGHTS' own leaves the process with the code of an error.
void Interpreter::end_script() {
  pending_.clear();
  quits_ = true;
}

/// if CONDITION then COMMANDS [elif CONDITION COMMANDS] [else COMMANDS]
void Interpreter::choose() {
  Input& in = *lammps_.input;
  const Command words(in.arg, in.arg + in.narg);
  const auto wrong = [&] { lammps_.error->all(FLERR, "Illegal if command"); };
  const auto holds = [&](const std::string& condition) {
    Inside::set_line(in, condition);  // it may have stood in quotes
    Inside::substitute_line(in);
    char* text = Inside::the_line(in);
    if (std::strncmp(text, "property_", 9) == 0) {
      if (std::strlen(text) < 11) lammps_.error->all(FLERR, "Illegal if command, length of argument too short");
      return lammps_.modify->find_fix_property(text + 9, "property/global", "any", 0, 0, "if", false) != nullptr;
    }
    return in.variable->evaluate_boolean(text) != 0.0;
  };
  if (words.size() < 3 || words[1] != "then") wrong();
  bool taken = holds(words[0]);
  for (std::size_t i = 2;;) {
    std::size_t last = i;
    while (last < words.size() && words[last] != "elif" && words[last] != "else") ++last;
    if (taken) {
      if (last == i) wrong();
      for (std::size_t k = i; k < last; ++k)
        if (words[k].empty()) wrong();
      pending_.insert(pending_.begin(), words.begin() + std::ptrdiff_t(i), words.begin() + std::ptrdiff_t(last));
      return;
    }
    if (last == words.size()) return;
    if (last + 2 > words.size()) wrong();
    const bool is_elif = words[last] == "elif";
    taken = !is_elif || holds(words[last + 1]);
    i = last + (is_elif ? 2 : 1);
  }
}

ResumePoint Interpreter::here() const {
  ResumePoint p;
  if (rank_of(lammps_.world) != 0) return p;
  Input& in = *lammps_.input;
  p.variables = variables_;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const bool innermost = i + 1 == names_.size();
    FILE* file = Inside::the_infiles(in)[i];
    const long at = innermost && !line_.empty() ? begin_ : std::ftell(file);
    p.files.push_back({names_[i], at, text_checksum(beginning(names_[i], at))});
  }
  p.line = line_;
  p.pending.assign(pending_.begin(), pending_.end());
  p.jump_skip = Inside::the_jump_skip(in) != 0;
  p.done = done_;
  return p;
}

std::string Interpreter::open_files(const ResumePoint& point) {
  Input& in = *lammps_.input;
  const auto refused = [](const std::string& name, const std::string& found, const std::string& wanted) {
    return "-restart: found " + found + " " + name + ", wanted " + wanted;
  };
  if (variables_ != point.variables) {
    std::string now, then;
    for (const auto& v : variables_) now += " -var " + words_text(v);
    for (const auto& v : point.variables) then += " -var " + words_text(v);
    return "-restart: found other variables in the command line (" + (now.empty() ? "none" : now.substr(1)) +
           "), wanted those of the run that wrote the checkpoint (" + (then.empty() ? "none" : then.substr(1)) +
           "): the script has used them";
  }
  if (point.files.empty() || point.files[0].name != script_)
    return refused(script_, "the script",
                   (point.files.empty() ? "" : point.files[0].name) + ", which wrote the checkpoint");
  names_.clear();
  for (const OpenScript& f : point.files) {
    const std::size_t i = names_.size();
    const std::string text = beginning(f.name, f.at);
    if (long(text.size()) != f.at || text_checksum(text) != f.text)
      return refused(f.name, "another text in the first " + std::to_string(f.at) + " bytes of",
                     "the text that they had when the checkpoint was written: what the script has done cannot be "
                     "changed, only what comes after");
    if (i > 0) {
      if (Inside::the_nfile(in) == Inside::the_maxfile(in))
        Inside::the_infiles(in) = static_cast<FILE**>(lammps_.memory->srealloc(
            Inside::the_infiles(in), ++Inside::the_maxfile(in) * int(sizeof(FILE*)), "input:infiles"));
      lammps_.infile = Inside::the_infiles(in)[Inside::the_nfile(in)++] = std::fopen(f.name.c_str(), "r");
    }
    if (!lammps_.infile || std::fseek(lammps_.infile, f.at, SEEK_SET) != 0)
      return refused(f.name, "a file that can't be opened,", "the script that it was");
    names_.push_back(f.name);
  }
  return "";
}

void Interpreter::note_run() {
  if (done_.empty() || done_.back() != Command{kRunMade}) done_.push_back({kRunMade});
}

void Interpreter::again(Command c, const std::string& particles) {
  Input& in = *lammps_.input;
  if (c[0] == kRunMade) return on_run_();
  const bool makes_box = c[0] == "create_box" || c[0] == "read_data" || c[0] == "read_restart";
  if (makes_box) c = {"read_restart", particles};
  if (c[0] == "log" && c.size() == 2 && c[1] != "none") c.push_back("append");
  // What these have written so far stays.
  if (c[0] == "fix" && c.size() > 3 && (c[3] == "print" || c[3].rfind("massflow/mesh", 0) == 0))
    for (std::string& w : c)
      if (w == "file") w = "append";
  if (c[0] == "fix" && c.size() > 3 && c[3].rfind("ave/", 0) == 0 && rank_of(lammps_.world) == 0)
    for (std::size_t i = 4; i + 1 < c.size(); ++i)
      if (c[i] == "file") keep_file(c[i + 1]);
  Inside::set_line(in, words_text(c));
  if (int(c.size()) > Inside::the_maxarg(in)) {
    Inside::the_maxarg(in) = int(c.size());
    in.arg = static_cast<char**>(lammps_.memory->srealloc(in.arg, c.size() * sizeof(char*), "input:arg"));
  }
  in.narg = int(c.size()) - 1;
  for (int i = 0; i < in.narg; ++i) in.arg[i] = c[std::size_t(i) + 1].data();
  Inside::the_command(in) = c[0].data();
  if (!Inside::execute(in)) lammps_.error->all(FLERR, ("Unknown command: " + words_text(c)).c_str());
  const Atom& atom = *lammps_.atom;
  if (makes_box) masks_.assign(atom.mask, atom.mask + atom.nlocal);
}

std::string Interpreter::go_on_from(const ResumePoint& point, const std::string& particles) {
  agree(rank_of(lammps_.world) == 0 ? open_files(point) : "");
  done_ = point.done;
  for (const Command& c : point.done) again(c, particles);
  // Commands `group` have looked at the particles as they lie now.
  if (lammps_.atom->nlocal != int(masks_.size()))
    throw std::runtime_error("-restart: a command of the script has changed the number of particles");
  std::copy(masks_.begin(), masks_.end(), lammps_.atom->mask);
  Inside::the_jump_skip(*lammps_.input) = point.jump_skip;
  pending_.clear();
  if (!point.line.empty()) {
    std::string now;
    if (!next_line(now)) now = "nothing";
    pending_.assign(point.pending.begin(), point.pending.end());
    return now == point.line ? "" : now;
  }
  pending_.assign(point.pending.begin(), point.pending.end());
  return "";
}

Command Interpreter::words_of(const std::string& line) {
  Input& in = *lammps_.input;
  Inside::set_line(in, line);
  Inside::parse_line(in);
  Command c;
  if (Inside::the_command(in)) {
    c.push_back(Inside::the_command(in));
    c.insert(c.end(), in.arg, in.arg + in.narg);
  }
  return c;
}

}  // namespace twogrid
