// How sure the means are, in words.
#pragma once

#include <string>

namespace twogrid {

struct MeansError;

/// "0.123 s".
std::string seconds(double time);
/// weight: of the means (s). until: relative standard error that is wanted; 0: none. met: it is. too_short: what it still wants
/// whatever the errors are; of_one: where a single batch's scatter is to be enough; empty: nothing. Empty where there is nothing
/// to say.
std::string sureness_text(const MeansError& error, double weight, double until, bool met, const std::string& too_short,
                          const std::string& of_one);

}  // namespace twogrid
