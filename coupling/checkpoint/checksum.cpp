#include "coupling/checkpoint/checksum.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <vector>

namespace twogrid {

namespace {

constexpr std::uint64_t kOdd[2] = {0x9e3779b97f4a7c15u, 0xd6e8feb86659fd93u};
constexpr std::size_t kPiece = 1 << 20;
constexpr char kSeal[] = "\ntwogrid seal ";
constexpr std::size_t kSealLength = sizeof kSeal - 1 + 16 + 1;  // with the digits and a line's end

/// One to one in h for every word, and in word for every h.
std::uint64_t mixed(std::uint64_t h, std::uint64_t word) {
  h = (h ^ word) * kOdd[0];
  return h ^ (h >> 32);
}

struct Close {
  void operator()(std::FILE* f) const { std::fclose(f); }
};
using File = std::unique_ptr<std::FILE, Close>;

/// Of the file's first `count` bytes, or all. Empty: done; else why not.
std::string sum_of(std::FILE* f, std::uint64_t count, Checksum& sum) {
  std::vector<unsigned char> piece(kPiece);
  while (count > 0) {
    const std::size_t got = std::fread(piece.data(), 1, std::size_t(std::min<std::uint64_t>(count, kPiece)), f);
    if (got == 0) break;
    sum.add(piece.data(), got);
    count -= got;
  }
  return std::ferror(f) ? std::strerror(errno) : "";
}

}  // namespace

void Checksum::take(const unsigned char* block) {
  std::array<std::uint64_t, kLanes> word;
  std::memcpy(word.data(), block, kBlock);
  for (int l = 0; l < kLanes; ++l) lane_[l] = mixed(lane_[l], word[l]);
}

void Checksum::add(const void* bytes, std::size_t count) {
  const auto* at = static_cast<const unsigned char*>(bytes);
  const std::size_t begun = length_ % kBlock;
  length_ += count;
  if (begun > 0) {
    const std::size_t more = std::min(count, kBlock - begun);
    std::copy_n(at, more, begun_.data() + begun);
    at += more, count -= more;
    if (begun + more < kBlock) return;
    take(begun_.data());
  }
  for (; count >= kBlock; at += kBlock, count -= kBlock) take(at);
  std::copy_n(at, count, begun_.data());
}

std::uint64_t Checksum::value() const {
  Checksum end = *this;
  const std::size_t begun = length_ % kBlock;
  if (begun > 0) {
    std::fill(end.begun_.begin() + begun, end.begun_.end(), 0);
    end.take(end.begun_.data());
  }
  // One to one in each lane.
  std::uint64_t h = length_;
  for (std::uint64_t lane : end.lane_) h = mixed(h, lane) * kOdd[1];
  return h ^ (h >> 29);
}

std::string Checksum::text() const {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", (unsigned long long)value());
  return digits;
}

std::string text_checksum(const std::string& bytes) {
  Checksum sum;
  sum.add(bytes.data(), bytes.size());
  return sum.text();
}

std::string file_checksum(const std::string& path) {
  const File f(std::fopen(path.c_str(), "rb"));
  Checksum sum;
  const std::string why = f ? sum_of(f.get(), ~std::uint64_t(0), sum) : std::strerror(errno);
  if (!why.empty()) throw std::runtime_error("the file '" + path + "' cannot be read (" + why + ")");
  return sum.text();
}

std::string seal_file(const std::string& path) {
  const File f(std::fopen(path.c_str(), "r+b"));
  if (!f) return std::strerror(errno);
  Checksum sum;
  if (std::string why = sum_of(f.get(), ~std::uint64_t(0), sum); !why.empty()) return why;
  const std::string line = kSeal + sum.text() + "\n";
  if (std::fseek(f.get(), 0, SEEK_END) != 0 || std::fwrite(line.data(), 1, line.size(), f.get()) != line.size() ||
      std::fflush(f.get()) != 0)
    return std::strerror(errno);
  return "";
}

std::string broken_seal(const std::string& path) {
  std::error_code e;
  if (std::filesystem::exists(path, e) && !std::filesystem::is_regular_file(path, e)) return "it is no regular file";
  const File f(std::fopen(path.c_str(), "rb"));
  if (!f || std::fseek(f.get(), 0, SEEK_END) != 0) return std::strerror(errno);
  const long size = std::ftell(f.get());
  char line[kSealLength + 1] = {};
  const bool sealed = size >= long(kSealLength) && std::fseek(f.get(), size - long(kSealLength), SEEK_SET) == 0 &&
                      std::fread(line, 1, kSealLength, f.get()) == kSealLength &&
                      std::strncmp(line, kSeal, sizeof kSeal - 1) == 0 && line[kSealLength - 1] == '\n';
  if (!sealed) return "it is no checkpoint, or only a part of one (the checksum at its end is missing)";
  std::rewind(f.get());
  Checksum sum;
  if (std::string why = sum_of(f.get(), std::uint64_t(size) - kSealLength, sum); !why.empty()) return why;
  if (std::string(line + sizeof kSeal - 1, 16) == sum.text()) return "";
  return "it is damaged (its checksum is another than when it was written)";
}

}  // namespace twogrid
