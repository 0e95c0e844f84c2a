// Files of an earlier process that LIGGGHTS would write over.
#pragma once

#include <string>

namespace twogrid {

/// A file of that name gets another one: NAME.1, or the next number that is free. Nothing where there is none. One rank.
void keep_file(const std::string& name);

}  // namespace twogrid
