#include "liggghts_fixes/report/status.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <system_error>

#include "liggghts_fixes/script/words.h"

namespace twogrid {

namespace {

/// Bytes of the UTF-8 character that begins at p, within n bytes; 0: none does.
std::size_t character(const char* p, std::size_t n) {
  const auto byte = [p](std::size_t i) { return static_cast<unsigned char>(p[i]); };
  const std::size_t length = byte(0) < 0x80   ? 1
                             : byte(0) < 0xc2 ? 0
                             : byte(0) < 0xe0 ? 2
                             : byte(0) < 0xf0 ? 3
                             : byte(0) < 0xf5 ? 4
                                              : 0;
  if (length > n) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  return length;
}

/// Names of files may hold any bytes: those that are no text are shown by their numbers.
std::string quoted(const std::string& s) {
  std::string q = "\"";
  for (std::size_t i = 0; i < s.size();) {
    const std::size_t length = character(&s[i], s.size() - i);
    const auto byte = static_cast<unsigned char>(s[i]);
    if (length == 0 || byte < 0x20 || byte == 0x7f) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", byte);
      q += code;
    } else {
      if (byte == '"' || byte == '\\') q += '\\';
      q.append(s, i, length);
    }
    i += std::max<std::size_t>(1, length);
  }
  return q + "\"";
}

std::string number(double value) {
  return std::isfinite(value) ? exact(value) : "null";
}
/// Of figures that are never negative.
std::string known(double value) {
  return value < 0 ? "null" : number(value);
}
std::string known(long long value) {
  return value < 0 ? "null" : std::to_string(value);
}

/// "2026-11-28T17:20:19Z"
std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace

std::string status_json(const RunStatus& s) {
  const Report& r = s.report;
  std::string text = "{\n";
  const auto line = [&](const std::string& name, const std::string& value) {
    text += (text.back() == ',' ? "\n" : "") + ("  " + quoted(name)) + ": " + value + ",";
  };
  const auto of_fluid = [&](double value) { return s.fluid ? number(value) : std::string("null"); };
  line("state", quoted(s.state));
  line("error", s.error.empty() ? "null" : quoted(s.error));
  line("date", quoted(s.date));
  line("started", quoted(s.started));
  line("program", quoted(s.program));
  line("ranks", std::to_string(s.ranks));
  line("wall_seconds", number(s.wall));
  line("time", of_fluid(r.fluid_time));
  line("step", std::to_string(s.step));
  const bool end_known = s.last_step >= 0;
  line("run", "{\"running\": " + std::string(s.running ? "true" : "false") +
                  ", \"first_step\": " + std::to_string(s.first_step) + ", \"last_step\": " + known(s.last_step) +
                  ", \"steps_done\": " + std::to_string(s.step - s.first_step) +
                  ", \"steps_to_go\": " + (end_known ? std::to_string(s.last_step - s.step) : "null") +
                  ", \"seconds_to_go\": " + (end_known && s.running ? known(s.to_go) : "null") + "}");
  line("steps_per_second", known(s.steps_per_second));
  line("wall_seconds_per_simulated_second", known(s.wall_per_simulated));
  line("particles", known(s.particles));
  line("particles_lost", std::to_string(s.lost));
  line("courant_number", of_fluid(r.cfl));
  line("fluid_step", of_fluid(r.fluid_dt));
  line("pressure_drop", of_fluid(r.pressure_drop));
  line("smallest_void_fraction", of_fluid(r.eps_min));
  line("ledger", "{\"solids_volume_error\": " + of_fluid(r.solid_volume_error) + ", \"momentum_error\": " +
                     of_fluid(r.momentum_error) + ", \"continuity_error\": " + of_fluid(r.divergence_error) +
                     ", \"volume_inserted\": " + of_fluid(r.inserted_total) + ", \"volume_vanished\": " +
                     of_fluid(r.vanished_total) + ", \"volume_grown\": " + of_fluid(r.grown_total) + "}");
  line("checkpoint", s.checkpoint.empty()
                         ? "null"
                         : "{\"path\": " + quoted(s.checkpoint) + ", \"step\": " + std::to_string(s.checkpoint_step) +
                               ", \"date\": " + quoted(s.checkpoint_date) + "}");
  text.back() = '\n';
  return text + "}\n";
}

std::string status_name(const std::string& log) {
  if (log == "none") return "";
  const std::size_t slash = log.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : log.substr(0, slash + 1);
  std::string name = log.substr(folder.size());
  if (name == "log.liggghts") return folder + "status.json";
  if (name.size() > 4 && name.rfind("log.", 0) == 0) name.erase(0, 4);
  if (name.size() > 4 && name.substr(name.size() - 4) == ".log") name.resize(name.size() - 4);
  return folder + name + ".status.json";
}

Status& Status::of_process() {
  static Status status;
  return status;
}

void Status::open(const std::string& path, const std::string& program, int rank, int ranks) {
  std::error_code none;
  const std::filesystem::path whole = std::filesystem::absolute(path, none);  // scripts may change the folder
  path_ = path.empty() || none ? path : whole.string();
  rank_ = rank;
  began_ = Clock::now();
  status_.program = program;
  status_.ranks = ranks;
  status_.started = date_now();
  write();
}

void Status::begin_run(long long step, long long first, long long last) {
  if (path_.empty()) return;
  status_.running = true;
  status_.step = step;
  status_.first_step = first;
  status_.last_step = last;
  status_.steps_per_second = status_.wall_per_simulated = status_.to_go = RunStatus::kUnknown;
  mark_ = Clock::now();
  mark_step_ = step;
  mark_time_ = status_.report.fluid_time;
  wait_ = kFirst;
  write_of_run();
}

void Status::end_at(long long step) {
  if (status_.last_step > step) status_.last_step = step;
}

void Status::step(long long step) {
  if (path_.empty()) return;
  status_.step = step;
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  measure_rate(now);
  write();
}

void Status::couple(long long step, const Report& report, const ScheduleState& schedule, long long inserted) {
  if (path_.empty()) return;
  status_.report = report;
  status_.fluid = true;
  status_.particles = schedule.particles + inserted;
  status_.lost = schedule.lost;
  this->step(step);
}

/// Since the file before: a bed's rate changes as it fills, or bubbles.
void Status::measure_rate(Clock::time_point now) {
  const double spent = std::chrono::duration<double>(now - mark_).count();
  const long long steps = status_.step - mark_step_;
  if (!(spent > 0) || steps <= 0) return;
  status_.steps_per_second = double(steps) / spent;
  const double simulated = status_.report.fluid_time - mark_time_;
  status_.wall_per_simulated = simulated > 0 ? spent / simulated : RunStatus::kUnknown;
  status_.to_go =
      status_.last_step < 0 ? RunStatus::kUnknown : double(status_.last_step - status_.step) / status_.steps_per_second;
  mark_ = now;
  mark_step_ = status_.step;
  mark_time_ = status_.report.fluid_time;
}

void Status::end_run(long long step) {
  if (path_.empty()) return;
  status_.step = step;
  measure_rate(Clock::now());
  status_.running = false;
  write_of_run();
}

void Status::checkpoint(const std::string& path, long long step) {
  status_.checkpoint = path;
  status_.checkpoint_step = step;
  status_.checkpoint_date = date_now();
  write();
}

void Status::finish() {
  end("finished", "");
}

void Status::end_by_signal(int number, const std::string& sentence) {
  end("ended by signal " + std::to_string(number), sentence);
}

void Status::fail(const std::string& sentence) {
  end("error", sentence);
}

void Status::fail_alone(const std::string& sentence) {
  end("error", sentence, true);
}

void Status::end(const std::string& state, const std::string& sentence, bool any_rank) {
  if (ended_) return;
  ended_ = true;
  status_.state = state;
  status_.error = sentence;
  status_.running = false;
  write(any_rank);
}

void Status::write_of_run() {
  const double since = std::chrono::duration<double>(Clock::now() - began_).count() - status_.wall;
  if (++runs_ <= kManyRuns || since > kPause) write();
}

void Status::write(bool any_rank) {
  if (path_.empty()) return;
  const Clock::time_point now = Clock::now();
  next_ = now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(wait_));
  wait_ = std::min(2 * wait_, kSeconds);
  if (rank_ != 0 && !any_rank) return;
  status_.date = date_now();
  status_.wall = std::chrono::duration<double>(now - began_).count();
  const std::string text = status_json(status_);
  const std::string part = path_ + (rank_ == 0 ? "" : "." + std::to_string(rank_)) + ".part";
  std::FILE* const file = std::fopen(part.c_str(), "w");
  if (!file) return;
  const bool whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  if (std::fclose(file) != 0 || !whole || std::rename(part.c_str(), path_.c_str()) != 0) unlink(part.c_str());
}

void open_status(const std::string& log, const std::string& program, MPI_Comm comm) {
  int rank = 0, ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  Status::of_process().open(status_name(log), program, rank, ranks);
}

}  // namespace twogrid
