#include "mle/maintain/shared_changes.h"

#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

// Two outputs, two inputs; dead times of 3 min, sampled every 0.5 min.
OutputErrorFit Fit(const std::vector<double>& delays, double error) {
  OutputErrorFit fit;
  fit.model = ProcessModel("column", "min", {{"reflux", ""}, {"steam", ""}},
                           {{"top", ""}, {"bottom", ""}});
  for (const double delay : delays) {
    ElementEstimate& element = fit.elements.emplace_back();
    element.state = ElementState::kFitted;
    element.delay = {.initial = 3.0, .value = delay, .standard_error = error};
  }
  return fit;
}

TEST(SharedDelays, OfARow) {
  const auto found = FindSharedDelays(Fit({3.9, 4.1, 3.0, 3.05}, 0.1), 0.5);
  ASSERT_EQ(found.size(), 1);
  EXPECT_TRUE(found[0].is_output);
  EXPECT_EQ(found[0].channel, 0);
  EXPECT_NEAR(found[0].change, 1.0, 1e-12);
  // Of two, each known to within √(0.1² + (0.5/4)²).
  EXPECT_NEAR(found[0].error, 0.1601 / 1.41421, 1e-4);
  EXPECT_TRUE(found[0].contains(0, 1));
  EXPECT_FALSE(found[0].contains(1, 0));
  EXPECT_THAT(found[0].Describe(Fit({3, 3, 3, 3}, 0.1).model),
              HasSubstr("All dead times to top seem to be 1 min longer"));
  EXPECT_THAT(found[0].Describe(Fit({3, 3, 3, 3}, 0.1).model),
              HasSubstr("time stamps of top are late"));
}

// A late input looks like shorter dead times.
TEST(SharedDelays, OfAColumn) {
  const auto found = FindSharedDelays(Fit({3.0, 2.0, 3.05, 2.1}, 0.1), 0.5);
  ASSERT_EQ(found.size(), 1);
  EXPECT_FALSE(found[0].is_output);
  EXPECT_EQ(found[0].channel, 1);
  EXPECT_LT(found[0].change, -0.9);
  EXPECT_THAT(
      found[0].Describe(Fit({3, 3, 3, 3}, 0.1).model),
      HasSubstr("All dead times from steam seem to be 0.95 min shorter"));
  EXPECT_THAT(found[0].Describe(Fit({3, 3, 3, 3}, 0.1).model),
              HasSubstr("time stamps of steam are late"));
}

TEST(SharedDelays, NotOfOneElement) {
  EXPECT_TRUE(FindSharedDelays(Fit({4.0, 3.0, 3.0, 3.0}, 0.1), 0.5).empty());
  // One that is not fitted says nothing, and one alone is not shared.
  OutputErrorFit fit = Fit({4.0, 3.0, 3.0, 3.0}, 0.1);
  fit.elements[1].state = ElementState::kNotInformed;
  fit.elements[2].state = ElementState::kAbsent;
  EXPECT_TRUE(FindSharedDelays(fit, 0.5).empty());
}

TEST(SharedDelays, NotOfDifferentChanges) {
  EXPECT_TRUE(FindSharedDelays(Fit({4.0, 5.0, 3.0, 3.0}, 0.1), 0.5).empty());
  // Within their errors they are alike.
  EXPECT_EQ(FindSharedDelays(Fit({4.0, 5.0, 3.0, 3.0}, 0.3), 0.5).size(), 1);
}

TEST(SharedDelays, NotWithinTheErrors) {
  EXPECT_TRUE(FindSharedDelays(Fit({3.3, 3.3, 3.0, 3.0}, 0.2), 0.5).empty());
  EXPECT_TRUE(FindSharedDelays(Fit({3.1, 3.1, 3.0, 3.0}, 0.0), 0.5).empty());
}

// One that the records hardly determine is near to 0 and to the others alike.
TEST(SharedDelays, WhereOneElementSaysLittle) {
  OutputErrorFit fit;
  fit.model = ProcessModel("column", "min",
                           {{"reflux", ""}, {"steam", ""}, {"side", ""}},
                           {{"top", ""}});
  const auto set = [&](const std::vector<double>& delays,
                       const std::vector<double>& errors) {
    fit.elements.assign(3, {});
    for (int j = 0; j < 3; ++j) {
      fit.elements[j].state = ElementState::kFitted;
      fit.elements[j].delay = {
          .initial = 3.0, .value = delays[j], .standard_error = errors[j]};
    }
  };
  set({4.0, 4.1, 3.2}, {0.1, 0.1, 1.0});
  ASSERT_EQ(FindSharedDelays(fit, 0.5).size(), 1);
  EXPECT_NEAR(FindSharedDelays(fit, 0.5)[0].change, 1.05, 0.02);
  // One alone that says much is its own.
  set({4.0, 3.2, 3.2}, {0.1, 1.0, 1.0});
  EXPECT_TRUE(FindSharedDelays(fit, 0.5).empty());
  // One that says much against it.
  set({4.0, 4.1, 3.3}, {0.1, 0.1, 0.2});
  EXPECT_TRUE(FindSharedDelays(fit, 0.5).empty());
}

// A dead time of 0.4 min cannot become 2 min shorter: it has come out as 0.
TEST(SharedDelays, ADeadTimeThatHasComeOutAsZeroIsNotAgainstIt) {
  OutputErrorFit fit = Fit({1.0, 3.0, 0.0, 3.05}, 0.1);
  fit.model = ProcessModel("column", "min", {{"reflux", ""}, {"steam", ""}},
                           {{"top", ""}, {"middle", ""}, {"bottom", ""}});
  for (const double delay : {1.1, 2.95}) {
    ElementEstimate& element = fit.elements.emplace_back();
    element.state = ElementState::kFitted;
    element.delay = {.initial = 3.0, .value = delay, .standard_error = 0.1};
  }
  fit.elements[2].delay.initial = 0.4;
  const auto found = FindSharedDelays(fit, 0.5);
  ASSERT_EQ(found.size(), 1);
  EXPECT_FALSE(found[0].is_output);
  EXPECT_EQ(found[0].channel, 0);
  EXPECT_NEAR(found[0].change, -1.95, 1e-12);
  EXPECT_TRUE(found[0].impossible);
  EXPECT_THAT(found[0].Describe(fit.model),
              HasSubstr("The time stamps of reflux seem to be 1.95 min late"));
  EXPECT_THAT(found[0].Describe(fit.model),
              HasSubstr("would have to be negative"));
  // One that has become shorter by less, and not to 0, is against it.
  fit.elements[2].delay.value = 0.2;
  EXPECT_TRUE(FindSharedDelays(fit, 0.5).empty());
  // Alone with one that is at 0 an element is its own.
  fit.elements[2].delay.value = 0.0;
  fit.elements[4].state = ElementState::kNotInformed;
  EXPECT_TRUE(FindSharedDelays(fit, 0.5).empty());
}

TEST(SharedGain, OfAColumn) {
  OutputErrorFit fit = Fit({3, 3, 3, 3}, 0.1);
  const auto set = [&](int place, double initial, double value, double error) {
    fit.elements[place].gain = {
        .initial = initial, .value = value, .standard_error = error};
  };
  // Steam has 20 % more in both, of different signs; reflux in one.
  set(0, 2.0, 2.4, 0.02);
  set(1, -5.0, -6.0, 0.05);
  set(2, 1.0, 1.0, 0.01);
  set(3, 0.3, 0.36, 0.01);
  EXPECT_FALSE(FindSharedGain(fit, 0).has_value());
  ASSERT_TRUE(FindSharedGain(fit, 1).has_value());
  EXPECT_NEAR(*FindSharedGain(fit, 1), 0.2, 1e-12);
  fit.elements[3].state = ElementState::kNotInformed;
  EXPECT_FALSE(FindSharedGain(fit, 1).has_value());
}

// A column of three, of which the third hardly says anything: it may as well
// have changed as not, which is no reason to doubt the others.
TEST(SharedGain, NotWhereOneElementSaysLittle) {
  OutputErrorFit fit;
  fit.model = ProcessModel("column", "min", {{"steam", ""}},
                           {{"top", ""}, {"middle", ""}, {"bottom", ""}});
  fit.elements.assign(3, {});
  for (ElementEstimate& element : fit.elements) {
    element.state = ElementState::kFitted;
    element.gain = {.initial = 1.0, .value = 1.2, .standard_error = 0.02};
  }
  EXPECT_TRUE(FindSharedGain(fit, 0).has_value());
  fit.elements[2].gain.value = 1.05;
  fit.elements[2].gain.standard_error = 0.3;
  EXPECT_FALSE(FindSharedGain(fit, 0).has_value());
}

}  // namespace
}  // namespace mle
