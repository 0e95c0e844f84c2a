// The fuzzer: scripts' words, the command line, runs, records and checkpoint files, mutated and handed to the functions
// that read them. Wanted of each: a sentence, or something that makes sense, without memory for what a number of theirs
// promises. Own driver: fixed seeds, no library.
//
//   fuzz [--tries N] [--seed S] [--only PART] [--try K] [--verbose]
//
// Exit 1 on any defect; a crash or a try that takes more than 20 s ends it with what was tried.
#include <mpi.h>
#include <petscsys.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/fuzz/fuzz.h"

namespace twogrid_fuzz {
namespace {

constexpr unsigned kLimit = 20;       // s a try
constexpr long kMemory = 512 * 1024;  // kB that a try may take beyond what those before took
std::string now, at;

/// Most memory that the process has had so far (kB).
long memory() {
  rusage use = {};
  getrusage(RUSAGE_SELF, &use);
  return use.ru_maxrss;
}

void on_signal(int number) {
  const auto say = [](const char* s, std::size_t n) {
    if (write(2, s, n) < 0) _exit(3);
  };
  const char* what = number == SIGALRM ? "HANGS: " : "CRASHES: ";
  say(what, std::strlen(what)), say(at.data(), at.size()), say("\n", 1);
  say(now.data(), now.size()), say("\n", 1);
  signal(number, SIG_DFL);
  raise(number == SIGALRM ? SIGKILL : number);
}

struct Part {
  const char* name;
  int share;  // of 100 tries
  Verdict (*one)(Dice&);
};

const Part kParts[] = {{"script", 50, try_script},
                       {"command_line", 5, try_command_line},
                       {"run_request", 10, try_run_request},
                       {"resume_point", 10, try_resume_point},
                       {"checkpoint_folder", 5, try_checkpoint_folder},
                       {"checkpoint_file", 15, try_checkpoint_file},
                       {"checkpoint_promise", 5, try_checkpoint_promise}};

int run(int argc, char** argv) {
  long tries = 2000, single = -1;
  unsigned long seed = 20261128;
  std::string only;
  bool verbose = false;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto next = [&] { return i + 1 < argc ? argv[++i] : ""; };
    if (word == "--tries")
      tries = std::atol(next());
    else if (word == "--seed")
      seed = std::strtoul(next(), nullptr, 10);
    else if (word == "--try")
      single = std::atol(next());
    else if (word == "--only")
      only = next();
    else if (word == "--verbose")
      verbose = true;
    else
      return std::fprintf(stderr, "fuzz: found %s, wanted --tries, --seed, --only, --try or --verbose\n", word.c_str()),
             2;
  }
  for (int s : {SIGSEGV, SIGFPE, SIGABRT, SIGBUS, SIGILL, SIGALRM}) signal(s, on_signal);

  int share = 0;
  for (const Part& p : kParts) share += p.share;
  long defects = 0, all = 0;
  for (const Part& p : kParts) {
    if (!only.empty() && only != p.name) continue;
    const long n = only.empty() ? (tries * p.share + share - 1) / share : tries;
    long accepted = 0, bad = 0;
    const auto begin = std::chrono::steady_clock::now();
    for (long k = single >= 0 ? single : 0; k < (single >= 0 ? single + 1 : n); ++k, ++all) {
      at = std::string("--only ") + p.name + " --seed " + std::to_string(seed) + " --try " + std::to_string(k);
      now.clear();
      alarm(kLimit);
      Dice dice(seed * 1000003u + std::uint64_t(k) * 7919u + std::uint64_t(p.name[0]));
      const long before = memory();
      Verdict v = p.one(dice);
      alarm(0);
      if (v.defect.empty() && memory() > before + kMemory)
        v.defect = "takes " + std::to_string((memory() - before) / 1024) + " MB";
      accepted += v.accepted;
      if (verbose) std::printf("%s: %s\n", v.accepted ? "accepted" : "refused", now.substr(0, 2000).c_str());
      if (v.defect.empty()) continue;
      if (++bad <= 20)
        std::printf("DEFECT (%s): %s\n  %s\n", at.c_str(), v.defect.c_str(), now.substr(0, 2000).c_str());
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("%-18s %6ld tries, %6ld accepted, %ld defects, %.1f s\n", p.name, single >= 0 ? 1 : n, accepted, bad,
                seconds);
    // Where nothing is accepted, or all, the mutations are no test.
    if (single < 0 && n >= 200 && (accepted == 0 || accepted == n))
      std::printf("DEFECT: %s tests nothing\n", p.name), ++bad;
    defects += bad;
  }
  if (crashes_in_hdf5 > 0)
    std::printf("%ld crashes within libhdf5, of files whose checksum was made anew over the damage\n", crashes_in_hdf5);
  std::printf("%ld tries, %ld defects\n", all, defects);
  return defects || !all ? 1 : 0;
}

}  // namespace

void note(const std::string& what) {
  now = what;
}

const std::string& folder() {
  static const std::string kFolder = [] {
    char name[] = "fuzz.XXXXXX";
    if (!mkdtemp(name)) std::perror("fuzz"), std::exit(2);
    return std::filesystem::absolute(name).string();
  }();
  return kFolder;
}

}  // namespace twogrid_fuzz

int main(int argc, char** argv) {
  int none = 1;
  if (PetscInitialize(&none, &argv, nullptr, nullptr)) return 2;
  PetscPopSignalHandler();
  const int status = twogrid_fuzz::run(argc, argv);
  std::error_code e;
  std::filesystem::remove_all(twogrid_fuzz::folder(), e);
  PetscFinalize();
  return status;
}
