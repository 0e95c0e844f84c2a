// Checksums of files: every flipped bit is seen, however the bytes come, and so is every cut.
// Without this test a checkpoint that a disk has damaged could be gone on from.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <set>
#include <vector>

#include "coupling/checkpoint/checksum.h"

namespace twogrid_test {
namespace {

using namespace twogrid;

std::vector<unsigned char> some_bytes(int n) {
  std::vector<unsigned char> b(n);
  unsigned s = 7;
  for (auto& c : b) c = (unsigned char)((s = s * 1664525u + 1013904223u) >> 24);
  return b;
}

std::uint64_t sum(const std::vector<unsigned char>& b) {
  Checksum c;
  c.add(b.data(), b.size());
  return c.value();
}

TEST(Checksum, SeesEveryFlippedBitAndLength) {
  std::set<std::uint64_t> seen;
  std::size_t count = 0;
  for (int n : {1, 7, 8, 31, 32, 33, 200}) {
    for (bool zeros : {true, false}) {
      std::vector<unsigned char> b = zeros ? std::vector<unsigned char>(n, 0) : some_bytes(n);
      seen.insert(sum(b)), ++count;
      for (int bit = 0; bit < 8 * n; ++bit) {
        b[bit / 8] ^= (unsigned char)(1 << bit % 8);
        seen.insert(sum(b)), ++count;
        b[bit / 8] ^= (unsigned char)(1 << bit % 8);
      }
    }
  }
  EXPECT_EQ(seen.size(), count);
}

TEST(Checksum, SeesWordsThatChangePlaces) {
  std::vector<unsigned char> b = some_bytes(256), c = b;
  for (int i = 0; i < 8; ++i) std::swap(c[i], c[8 + i]);
  EXPECT_NE(sum(b), sum(c));
  c = b;
  for (int i = 0; i < 32; ++i) std::swap(c[i], c[32 + i]);
  EXPECT_NE(sum(b), sum(c));
}

TEST(Checksum, DoesNotDependOnThePieces) {
  const std::vector<unsigned char> b = some_bytes(1000);
  for (int first : {0, 1, 5, 31, 32, 33, 64, 999})
    for (int piece : {1, 3, 32, 100}) {
      Checksum c;
      c.add(b.data(), first);
      for (int i = first; i < 1000; i += piece) c.add(&b[i], std::min(piece, 1000 - i));
      EXPECT_EQ(c.value(), sum(b)) << first << " " << piece;
    }
}

TEST(Checksum, OfAFileAndItsSeal) {
  const std::string path = "/tmp/twogrid_checksum_" + std::to_string(getpid());
  std::vector<unsigned char> b = some_bytes(3000);
  const auto put = [&] {
    std::FILE* f = std::fopen(path.c_str(), "wb");
    std::fwrite(b.data(), 1, b.size(), f);
    std::fclose(f);
  };
  put();
  Checksum c;
  c.add(b.data(), b.size());
  EXPECT_EQ(file_checksum(path), c.text());
  EXPECT_NE(broken_seal(path), "");
  EXPECT_EQ(seal_file(path), "");
  EXPECT_EQ(broken_seal(path), "");
  std::FILE* f = std::fopen(path.c_str(), "rb");
  b.resize(4000);
  b.resize(std::fread(b.data(), 1, b.size(), f));
  std::fclose(f);
  EXPECT_GT(b.size(), 3000u);
  for (std::size_t at = 0; at < b.size(); at += 1 + (at < 2990 ? 97 : 0)) {
    b[at] ^= 16;
    put();
    EXPECT_NE(broken_seal(path), "") << at;
    b[at] ^= 16;
  }
  while (b.size() > 250) {
    b.resize(b.size() - (b.size() > 2990 ? 1 : 200));
    put();
    EXPECT_NE(broken_seal(path), "") << b.size();
  }
  unlink(path.c_str());
  EXPECT_THROW(file_checksum(path), std::runtime_error);
  EXPECT_NE(broken_seal(path), "");
}

TEST(Checksum, IsFast) {
  const std::vector<unsigned char> b = some_bytes(1 << 25);
  const auto start = std::chrono::steady_clock::now();
  const std::uint64_t value = sum(b);
  const double s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_NE(value, 0u);
  std::printf("%.2f GB/s\n", 1e-9 * double(b.size()) / s);
}

}  // namespace
}  // namespace twogrid_test
