// What the parts of the fuzzer share: dice, mutations of words and bytes, and the verdict on what a function under test
// did with them. Every try has a seed of its own, so that any of them can be repeated alone.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace twogrid_fuzz {

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  /// 0 to n - 1.
  std::size_t below(std::size_t n) { return n == 0 ? 0 : std::size_t(engine_() % n); }
  bool one_in(std::size_t n) { return below(n) == 0; }
  template <class T>
  const T& of(const std::vector<T>& list) {
    return list[below(list.size())];
  }

 private:
  std::mt19937_64 engine_;
};

/// Words that no one means.
const std::vector<std::string>& odd_words();
/// Drops, repeats, swaps, replaces, cuts and splices words; `others`: lines to splice from.
void mutate(std::vector<std::string>& words, Dice& dice, const std::vector<std::vector<std::string>>& others);
/// Flips bits, cuts, repeats, zeroes and swaps blocks.
void mutate_bytes(std::string& bytes, Dice& dice);
/// Drops, repeats and swaps lines; puts odd words in place of numbers.
void mutate_text(std::string& text, Dice& dice);
std::string joined(const std::vector<std::string>& words);

/// Of checkpoint files whose checksum was made anew over damaged data of HDF5's own.
extern long crashes_in_hdf5;

/// What is being tried: printed if the program crashes or hangs over it.
void note(const std::string& what);

struct Verdict {
  bool accepted = false;
  std::string defect;  ///< empty: none
};

/// Runs f. Wanted: it returns, or throws std::invalid_argument or std::runtime_error with a sentence that says what is
/// wanted, or names a word of those tried.
Verdict tried(const std::function<void()>& f, const std::vector<std::string>& words);

/// A quantity that must lie in its range after something was accepted.
struct Bound {
  std::string what;
  double value, least, most;
};
/// The first that doesn't; empty: all do.
std::string outside(const std::vector<Bound>& bounds);

/// A folder of this process; removed at the end.
const std::string& folder();

// The parts. Each makes one try.
Verdict try_script(Dice& dice);
Verdict try_command_line(Dice& dice);
Verdict try_run_request(Dice& dice);
Verdict try_resume_point(Dice& dice);
Verdict try_checkpoint_folder(Dice& dice);
Verdict try_checkpoint_promise(Dice&);
Verdict try_checkpoint_file(Dice& dice);

}  // namespace twogrid_fuzz
