// Whatever stands in a database, its rows come out of the reader of CSV as they
// went in: a row a line, every value in its field.

#include "mle/database/table_text.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "gtest/gtest.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"

namespace mle {
namespace {

TEST(TableTextTest, AnyBytesStayInTheirField) {
  std::mt19937_64 random(1);
  // Mostly those that have a meaning.
  const std::string special("\",\n\r\t\0 x=;'\\", 12);
  for (int turn = 0; turn < 2000; ++turn) {
    const int columns = 1 + static_cast<int>(random() % 4);
    const int rows = 1 + static_cast<int>(random() % 5);
    TableText text;
    std::vector<std::vector<std::string>> written;
    for (int r = 0; r < rows; ++r) {
      std::vector<std::string>& row = written.emplace_back();
      for (int c = 0; c < columns; ++c) {
        std::string& value = row.emplace_back();
        const auto size = random() % 6;
        for (std::uint64_t k = 0; k < size; ++k) {
          value += random() % 3 == 0 ? static_cast<char>(random() % 256)
                                     : special[random() % special.size()];
        }
        if (r == 0) {
          text.AddName(value);
        } else {
          text.Add(std::string_view(value));
        }
      }
      text.EndRow();
    }
    std::istringstream in(text.text());
    CsvRows csv(in, "table");
    std::vector<std::string_view> fields;
    for (int r = 0; r < rows; ++r) {
      ASSERT_TRUE(csv.Next(fields)) << csv.status() << text.text();
      EXPECT_EQ(csv.line(), r + 1);
      ASSERT_EQ(fields.size(), static_cast<std::size_t>(columns));
      for (int c = 0; c < columns; ++c) {
        const std::string& value = written[r][c];
        bool has_control = false;
        for (const char byte : value) {
          has_control |= static_cast<unsigned char>(byte) < 0x20 ||
                         static_cast<unsigned char>(byte) == 0x7F;
        }
        if (!has_control) {
          // A byte-order mark cannot begin the text: names are quoted.
          EXPECT_EQ(fields[c], value);
        }
      }
    }
    EXPECT_FALSE(csv.Next(fields));
    EXPECT_TRUE(csv.status().ok()) << csv.status();
  }
}

TEST(TableTextTest, NumbersKeepTheirBits) {
  std::mt19937_64 random(2);
  std::vector<double> numbers = {
      0.0, -0.0, 0.1, 1e300, 5e-324, std::numeric_limits<double>::max()};
  for (int k = 0; k < 1000; ++k) {
    const auto bits = random();
    const auto number = std::bit_cast<double>(bits);
    if (std::isfinite(number)) numbers.push_back(number);
  }
  for (const double number : numbers) {
    TableText text;
    text.Add(number);
    double again = 0.0;
    ASSERT_TRUE(ReadCsvNumber(text.text(), again)) << text.text();
    EXPECT_EQ(std::bit_cast<std::uint64_t>(again),
              std::bit_cast<std::uint64_t>(number));
  }
  TableText text;
  text.Add(std::numeric_limits<std::int64_t>::min());
  text.AddNull();
  text.Add(std::int64_t{7});
  text.EndRow();
  EXPECT_EQ(text.text(), "-9223372036854775808,,7\n");
}

TEST(TableTextTest, ARowOfOneNullIsARow) {
  TableText text;
  text.AddNull();
  text.EndRow();
  std::istringstream in(text.text());
  CsvRows csv(in, "table");
  std::vector<std::string_view> fields;
  EXPECT_TRUE(csv.Next(fields));
}

}  // namespace
}  // namespace mle
