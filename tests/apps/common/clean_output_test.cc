#include "apps/common/clean_output.h"

#include <ostream>
#include <string>

#include "gtest/gtest.h"

namespace mle {
namespace {

std::string Cleaned(const std::string& text) {
  std::stringbuf kept;
  CleanBuffer buffer(&kept);
  std::ostream out(&buffer);
  out << text << std::flush;
  EXPECT_TRUE(out.good());
  return kept.str();
}

TEST(CleanOutputTest, TextIsHandedOnAsItIs) {
  for (const char* text : {"", "gain ← \"y\"\n\tT = 3\n", "温度 °C", "\n"}) {
    EXPECT_EQ(Cleaned(text), text);
  }
}

TEST(CleanOutputTest, WhatCommandsATerminalIsReplaced) {
  EXPECT_EQ(Cleaned("a\x1b[31mb\x07\r\x7f"), "a\uFFFD[31mb\uFFFD\uFFFD\uFFFD");
  EXPECT_EQ(Cleaned(std::string("\0x\0", 3)), "\uFFFDx\uFFFD");
}

TEST(CleanOutputTest, SingleCharactersAreLookedAtToo) {
  std::stringbuf kept;
  CleanBuffer buffer(&kept);
  std::ostream out(&buffer);
  out.put('a').put('\x1b').put('b');
  EXPECT_EQ(kept.str(), "a\uFFFDb");
}

// Takes `room` characters.
class FullBuffer : public std::streambuf {
 public:
  explicit FullBuffer(int room) : room_(room) {}

 protected:
  int_type overflow(int_type c) override {
    return room_-- > 0 ? c : traits_type::eof();
  }

 private:
  int room_;
};

TEST(CleanOutputTest, AFullDiskIsNoticed) {
  for (const char* text : {"abcdef", "abc\x1b"}) {
    FullBuffer full(4);
    CleanBuffer buffer(&full);
    std::ostream out(&buffer);
    out << text;
    EXPECT_FALSE(out.good()) << text;
  }
}

}  // namespace
}  // namespace mle
