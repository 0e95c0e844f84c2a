// A number that tells whether bytes are those that were written: 64 bits, of our own making. One flipped bit, or any
// change within one word of 8 bytes, always gives another; anything else is missed once in 2^64. No protection against
// intent. The same on all machines of one byte order, however the bytes are cut into pieces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace twogrid {

class Checksum {
 public:
  /// The next bytes.
  void add(const void* bytes, std::size_t count);
  /// Of all bytes so far.
  std::uint64_t value() const;
  /// The same as 16 hexadecimal digits.
  std::string text() const;

 private:
  static constexpr int kLanes = 4, kBlock = 8 * kLanes;
  void take(const unsigned char* block);

  std::array<std::uint64_t, kLanes> lane_{1, 2, 3, 4};
  std::array<unsigned char, kBlock> begun_{};  // a block whose end is still to come
  std::uint64_t length_ = 0;
};

/// Of these bytes, as text().
std::string text_checksum(const std::string& bytes);
/// Of a whole file, as text(). Reads it piece by piece, on the calling rank only. Throws std::runtime_error with a
/// sentence where it can't be read.
std::string file_checksum(const std::string& path);

/// Appends a line with the file's checksum to it. What is appended to an HDF5 file, HDF5 doesn't look at. Local. Empty:
/// done; else why not.
std::string seal_file(const std::string& path);
/// Whether a file ends with such a line and is as it was when that was written. Empty: yes; else what is wrong. Local.
std::string broken_seal(const std::string& path);

}  // namespace twogrid
