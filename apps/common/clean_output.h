// Names of tags and files are shown on terminals: control characters in them,
// which a terminal takes for commands, become U+FFFD.

#ifndef APPS_COMMON_CLEAN_OUTPUT_H_
#define APPS_COMMON_CLEAN_OUTPUT_H_

#include <streambuf>

namespace mle {

// Hands on to `to` what it is given; control characters but line breaks and
// tabs are replaced.
class CleanBuffer : public std::streambuf {
 public:
  explicit CleanBuffer(std::streambuf* to) : to_(to) {}

 protected:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int sync() override { return to_->pubsync(); }

 private:
  std::streambuf* to_;
};

// std::cout and std::cerr are clean from here on.
void CleanOutput();

// The original buffer of standard error, for control sequences to the terminal.
std::streambuf* UncleanErrors();

}  // namespace mle

#endif  // APPS_COMMON_CLEAN_OUTPUT_H_
