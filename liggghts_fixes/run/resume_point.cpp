#include "liggghts_fixes/run/resume_point.h"

#include <algorithm>
#include <iomanip>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace twogrid {

namespace {

constexpr int kFormat = 1;
constexpr long long kMostSteps = 9000000000000000;  // and particles
constexpr double kMostTime = 1e12;                  // s

void put(std::ostream& out, const std::vector<std::string>& words) {
  out << ' ' << words.size();
  for (const std::string& w : words) out << ' ' << std::quoted(w);
  out << '\n';
}

class Reader {
 public:
  explicit Reader(const std::string& text) : most_(text.size()), in_(text) {}
  void expect(const char* name) {
    std::string found;
    in_ >> found;
    if (found != name) broken(std::string("no '") + name + "' in its place");
  }
  template <class T>
  T number() {
    T value{};
    if (!(in_ >> value)) broken("no number in a place of one");
    return value;
  }
  template <class T>
  T number(const char* name, T least, T most) {
    expect(name);
    const T value = number<T>();
    if (!(value >= least && value <= most)) broken(std::string(name) + " out of all range");
    return value;
  }
  std::string word() {
    std::string w;
    if (!(in_ >> std::quoted(w))) broken("an end before its last word");
    return w;
  }
  /// Of what is to come: a text of so many bytes can't hold more.
  std::size_t count() {
    const long long n = number<long long>();
    if (n < 0 || n > most_) broken("a count out of all range");
    return std::size_t(n);
  }
  std::vector<std::string> words() {
    std::vector<std::string> w;
    for (std::size_t n = count(); n > 0; --n) w.push_back(word());
    return w;
  }
  /// least: words that each of them has.
  std::vector<std::vector<std::string>> lists(const char* name, std::size_t least) {
    expect(name);
    std::vector<std::vector<std::string>> all;
    for (std::size_t n = count(); n > 0; --n) {
      all.push_back(words());
      if (all.back().size() < least) broken(std::string(name) + " without words");
    }
    return all;
  }
  [[noreturn]] static void broken(const std::string& found) {
    throw std::invalid_argument("-restart: found a record of a checkpoint with " + found +
                                ", wanted one as twogrid writes it; name another checkpoint, or leave -restart out");
  }

 private:
  long long most_;
  std::istringstream in_;
};

bool one_of(const std::string& word, std::initializer_list<const char*> list) {
  return std::any_of(list.begin(), list.end(), [&](const char* w) { return word == w; });
}

}  // namespace

std::string to_text(const ResumePoint& p) {
  std::ostringstream out;
  out << std::setprecision(17) << "format " << kFormat << "\nstep " << p.step << "\ntime " << p.time << "\nparticles "
      << p.particles << "\nvariables " << p.variables.size() << '\n';
  for (const auto& v : p.variables) put(out, v);
  out << "files " << p.files.size() << '\n';
  for (const OpenScript& f : p.files) out << std::quoted(f.name) << ' ' << f.at << ' ' << std::quoted(f.text) << '\n';
  out << "line " << std::quoted(p.line) << "\npending";
  put(out, p.pending);
  out << "jump_skip " << p.jump_skip << "\nrun";
  put(out, p.run);
  out << "begin " << p.begin << " end " << p.end << "\ndone " << p.done.size() << '\n';
  for (const Command& c : p.done) put(out, c);
  out << "complete\n";
  return out.str();
}

ResumePoint resume_point(const std::string& text) {
  Reader in(text);
  ResumePoint p;
  in.expect("format");
  if (in.number<int>() != kFormat) Reader::broken("a format of another version of twogrid");
  p.step = in.number<long long>("step", 0, kMostSteps);
  p.time = in.number<double>("time", -kMostTime, kMostTime);
  p.particles = in.number<long long>("particles", 0, kMostSteps);
  p.variables = in.lists("variables", 1);
  in.expect("files");
  for (std::size_t n = in.count(); n > 0; --n) {
    OpenScript f;
    f.name = in.word(), f.at = in.number<long>(), f.text = in.word();
    if (f.at < 0) Reader::broken("a place before a script's beginning");
    p.files.push_back(f);
  }
  in.expect("line"), p.line = in.word();
  in.expect("pending"), p.pending = in.words();
  in.expect("jump_skip"), p.jump_skip = in.number<int>() != 0;
  in.expect("run"), p.run = in.words();
  p.begin = in.number<long long>("begin", 0, kMostSteps);
  p.end = in.number<long long>("end", 0, kMostSteps);
  p.done = in.lists("done", 1);
  in.expect("complete");
  if (!p.run.empty() && !(p.begin <= p.step && p.step <= p.end)) Reader::broken("a step outside its run");
  return p;
}

bool is_said_again(const Command& c, bool is_style) {
  const std::string& name = c.at(0);
  if (one_of(name, {"create_box", "read_data", "read_restart", "neigh_modify"})) return true;
  if (is_style) return false;
  if (one_of(name, {"if", "include", "jump", "label", "print", "quit", "partition", "reset_timestep", "thermo_log"}))
    return false;
  if (name == "shell") return c.size() > 1 && one_of(c[1], {"cd", "putenv"});
  return true;
}

void forget_scene(std::vector<Command>& done) {
  done.erase(std::remove_if(done.begin(), done.end(),
                            [](const Command& c) {
                              return !one_of(c.at(0), {"variable", "next", "shell", "log", "echo"});
                            }),
             done.end());
}

}  // namespace twogrid
