#include "mle/model/json_text.h"

#include <limits>

#include "gtest/gtest.h"

namespace mle {
namespace {

TEST(JsonTextTest, NumbersReadBackAndWhatIsNotFiniteIsNull) {
  const double infinity = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd matrix(2, 2);
  matrix << 0.1, -infinity, 1.0 / 3.0, std::numeric_limits<double>::quiet_NaN();
  const std::string text =
      FormatJson({{"second", 1e300}, {"first", MatrixJson(matrix)}});
  EXPECT_EQ(text,
            "{\n \"second\": 1e+300,\n \"first\": [\n  [\n   0.1,\n   null\n"
            "  ],\n  [\n   0.3333333333333333,\n   null\n  ]\n ]\n}\n");
  const auto read = nlohmann::ordered_json::parse(text);
  EXPECT_EQ(read["first"][1][0].get<double>(), 1.0 / 3.0);
}

TEST(JsonTextTest, WhatIsNotUtf8IsReplaced) {
  EXPECT_EQ(FormatJson("a\xFF"), "\"a\xEF\xBF\xBD\"\n");
}

}  // namespace
}  // namespace mle
