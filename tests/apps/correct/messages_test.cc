#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/correct/result.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle::correct {
namespace {

using ::testing::ElementsAre;

Message OfWindow(int number) {
  const std::string name = absl::StrCat("Window ", number);
  return {MessageCode::kWindowNotAtRest, name, name + " drifts.", {}};
}

TEST(MessagesTest, ManyOfOneKindAreOne) {
  const Message other = {MessageCode::kSticking, "u1", "u1 sticks.", {"tags"}};
  EXPECT_THAT(ShownTogether({OfWindow(1), other, OfWindow(2)}),
              ElementsAre("Window 1 drifts.", "u1 sticks. (--tags)",
                          "Window 2 drifts."));
  EXPECT_THAT(
      ShownTogether({OfWindow(1), other, OfWindow(2), OfWindow(5)}),
      ElementsAre("3 windows are not at rest where they should be; unmeasured "
                  "disturbances widen the intervals. Among them: Window 1, "
                  "Window 2.",
                  "u1 sticks. (--tags)"));
}

// Such a message is about the records as a whole.
TEST(MessagesTest, WhatHasNoPlaceStaysApart) {
  const Message all = {MessageCode::kWindowDropped, "", "Of 9 windows 5.", {}};
  EXPECT_THAT(ShownTogether({all, all, all}),
              ElementsAre(all.text, all.text, all.text));
}

}  // namespace
}  // namespace mle::correct
