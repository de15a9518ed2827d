// Files that are malformed or made to do harm: each is refused with its name,
// the line and the column.

#include <cstdint>
#include <memory>
#include <random>
#include <sstream>
#include <streambuf>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

ProcessModel HostileTank() {
  return ProcessModel("tank", "min", {{"steam", ""}, {"inflow", ""}},
                      {{"level", ""}, {"temperature", ""}});
}

struct Hostile {
  std::string what;
  std::string text;
  std::string message;  // a part of it
};

constexpr char kHeader[] = "time,level,temperature,steam,inflow\n";

// Six rows, the field at `row` and `column` (from 0) replaced.
std::string WithField(int row, int column, const std::string& field) {
  std::string text = kHeader;
  for (int r = 0; r < 6; ++r) {
    std::vector<std::string> fields = {absl::StrCat(r), "1.5", "2", "-3e1",
                                       "4"};
    if (r == row) fields[column] = field;
    text += absl::StrJoin(fields, ",") + "\n";
  }
  return text;
}

std::string Utf16(const std::string& text, bool big_endian, bool mark) {
  std::string wide;
  const auto add = [&](char high, char low) {
    wide += big_endian ? high : low;
    wide += big_endian ? low : high;
  };
  if (mark) add('\xFE', '\xFF');
  for (const char c : text) add('\0', c);
  return wide;
}

void AddFields(std::vector<Hostile>& files) {
  const std::string long_text(5000, 'x');
  for (const std::string field : {"1e999",
                                  "-1e999",
                                  "1e99999999999",
                                  "inf",
                                  "-inf",
                                  "Infinity",
                                  "0x10",
                                  "1.2.3",
                                  "\"1,2\"",
                                  "1 2",
                                  "--1",
                                  "+-1",
                                  "1e",
                                  "e5",
                                  "1_000",
                                  "$5",
                                  "5%",
                                  "NaN1",
                                  "nul",
                                  "\x01",
                                  "\xFF\xFE",
                                  "½",
                                  "٣",
                                  "\xF0\x9F\x98\x80",
                                  "<script>alert(1)</script>",
                                  "=1+1",
                                  "'1'",
                                  "1-",
                                  "1/2",
                                  "%s%n",
                                  long_text.c_str()}) {
    for (int column = 0; column < 5; ++column) {
      const int row = 1 + column % 4;
      files.push_back(
          {absl::StrCat("field ", field.substr(0, 20)),
           WithField(row, column, field),
           absl::StrCat("line ", row + 2, ", column ", column + 1)});
    }
  }
  // Numbers that cannot be squared and summed.
  for (const std::string field : {"1e61", "-1e155", "1e308"}) {
    for (int column = 1; column < 5; ++column) {
      files.push_back({"large sample", WithField(2, column, field),
                       absl::StrCat("line 4, column ", column + 1)});
    }
  }
  // A bad sample is no bad time.
  for (const std::string field : {"", "NaN", "Bad", "null"}) {
    files.push_back({"time that is bad", WithField(2, 0, field),
                     "line 4, column 1 ('time')"});
  }
}

void AddRows(std::vector<Hostile>& files) {
  const std::string header = kHeader;
  const std::string rows = "0,1,2,3,4\n1,1,2,3,4\n2,1,2,3,4\n";
  const auto add = [&](const std::string& what, const std::string& text,
                       const std::string& message) {
    files.push_back({what, text, message});
  };
  for (const std::string row : {"3", "3,1", "3,1,2", "3,1,2,3", "3,1,2,3,4,5",
                                "3;1;2;3;4", ",", ",,,,,", "3,1,2,3\t4"}) {
    add("fields " + row, header + rows + row + "\n", "line 5, column ");
  }
  // Cut anywhere before the last separator of the last row.
  for (int length = 1; length <= 7; ++length) {
    add("truncated", header + rows + std::string("3,1,2,3,4").substr(0, length),
        "line 5, column ");
  }
  add("quote", header + "0,1,\"2,3,4\n1,1,2,3,4\n",
      "line 2, column 3: the quote that opens here is not closed");
  add("quote", header + "0,1,\"2\"x,3,4\n", "line 2, column 3: text after");
  add("quote", header + "0,1,2\"2,3,4\n", "line 2, column 3: a quote inside");
  add("quote", header + "0,1,\"2\n", "line 2, column 3: the quote");
  add("carriage return", header + "0,1,2,3,4\r1,1,2,3,4\r",
      "line 2, column 5: a carriage return inside the line");
  std::string nul = header + rows;
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{7}, header.size() + 2, header.size() + 12,
        nul.size() - 2}) {
    std::string with_nul = nul;
    with_nul[at] = '\0';
    add("NUL", with_nul, "a NUL byte");
  }
  add("NUL in quotes", header + std::string("0,1,\"2\0\",3,4\n", 14),
      "line 2, column 3: a NUL byte");
}

void AddHeaders(std::vector<Hostile>& files) {
  const std::string rows = "0,1,2,3,4\n1,1,2,3,4\n2,1,2,3,4\n";
  const auto add = [&](const std::string& header, const std::string& message) {
    files.push_back(
        {"header " + header.substr(0, 30), header + "\n" + rows, message});
  };
  add("time,level,level,steam,inflow", "column 3: 'level' is duplicated");
  add("time,level, level ,steam,inflow", "column 3: 'level' is duplicated");
  add("time,time,temperature,steam,inflow", "column 2: 'time' is duplicated");
  add("time,levle,temperature,steam,inflow", "there is no column 'level'");
  add("Tiem,level,temperature,steam,inflow", "there is no column 'time'");
  add("Time,TIME,level,temperature,steam,inflow", "there is no column 'time'");
  add("time,level,temperature,steam", "there is no column 'inflow'");
  add("0,1,2,3,4", "line 1: there is no header");
  add("time,level,temperature,steam,inflow,foo",
      "column 6: 'foo' is neither time nor an input");
  add("time,level,temperature,steam,inflow,",
      "column 6: '' is neither time nor an input");
  add("time,level,temperature,steam,inflow,levle_setpoint",
      "column 6: 'levle_setpoint' is a set point of an output");
  add("time|level|temperature|steam|inflow", "there is no column 'inflow'");
  add("time,level,temperature,steam,\"inflow", "line 1, column 5: the quote");
  add("\"time\"\",level,temperature,steam,inflow", "line 1, column 1: ");
  add("<script>,level,temperature,steam,inflow", "there is no column 'time'");
  std::string wide = "time,level,temperature,steam,inflow";
  for (int c = 0; c < 100000; ++c) absl::StrAppend(&wide, ",tag", c);
  add(wide, "line 1, column 10001: there are more than 10000 columns");
  add(std::string(200000, ','), "line 1, column 10001: there are more");
  add("time,level,temperature,steam,inflow,level_quality,level_quality",
      "column 7: 'level_quality' is duplicated");

  for (const std::string text :
       {"", "\n", "\r\n\r\n", "\xEF\xBB\xBF", "\n\n\n\n"}) {
    files.push_back({"empty", text, "line 1, column 1: the file is empty"});
  }
  files.push_back({"header only", kHeader, "there is no row below the header"});
  files.push_back(
      {"one row", absl::StrCat(kHeader, "0,1,2,3,4\n"), "line 2, column 1"});
}

void AddTimes(std::vector<Hostile>& files) {
  for (int row = 1; row < 6; ++row) {
    files.push_back({"back", WithField(row, 0, absl::StrCat(row - 3)),
                     absl::StrCat("line ", row + 2, ", column 1 ('time')")});
    files.push_back({"twice", WithField(row, 0, absl::StrCat(row - 1)),
                     absl::StrCat("line ", row + 2, ", column 1 ('time')")});
    files.push_back({"date among numbers",
                     WithField(row, 0, "2024-01-01T00:00:00Z"),
                     absl::StrCat("line ", row + 2, ", column 1 ('time')")});
  }
  const std::string rows =
      absl::StrCat(kHeader, "2024-02-28 00:00:00,1,2,3,4\n");
  for (const std::string date :
       {"2024-02-30 00:00:00", "2023-02-29 00:00:00", "2024-13-01 00:00:00",
        "2024-00-01 00:00:00", "2024-02-28 24:00:01", "2024-02-28 00:60:00",
        "2024-02-28 00:00:60", "2024-02-28", "28.02.2024 00:00:00",
        "02/28/2024 00:00:00", "2024-02-28 00:00:00 CET", "1.5", "20240228",
        "2024-02-28 00:00:00+25:00", "0000-01-01 00:00:00",
        "2024-02-28 00:00:00Z garbage", "-2024-02-28 00:00:00"}) {
    files.push_back({"date " + date, rows + date + ",1,2,3,4\n",
                     "line 3, column 1 ('time')"});
  }
}

void AddEncodings(std::vector<Hostile>& files) {
  const std::string text = WithField(0, 0, "0");
  for (const bool big_endian : {false, true}) {
    files.push_back({"UTF-16", Utf16(text, big_endian, true),
                     "line 1, column 1: the file is in UTF-16"});
    files.push_back({"UTF-16", Utf16(text, big_endian, false), "a NUL byte"});
  }
  const auto add = [&](const std::string& what, const std::string& start) {
    std::mt19937_64 engine(start.size());
    std::string binary = start;
    for (int k = 0; k < 4000; ++k) binary += static_cast<char>(engine());
    files.push_back({what, binary, "column"});
  };
  add("gzip", "\x1F\x8B\x08");
  add("zip", "PK\x03\x04");
  add("PDF", "%PDF-1.7\n");
  add("ELF",
      "\x7F"
      "ELF");
  add("PNG", "\x89PNG\r\n\x1A\n");
  for (unsigned seed = 0; seed < 40; ++seed) {
    std::mt19937_64 engine(seed);
    std::string noise(engine() % 3000 + 1, ' ');
    for (char& c : noise) c = static_cast<char>(engine());
    files.push_back({absl::StrCat("random ", seed), noise, "column"});
  }
  // A file that goes bad half-way.
  for (unsigned seed = 0; seed < 10; ++seed) {
    std::mt19937_64 engine(seed);
    std::string damaged = text + "6,1,2,";
    for (int k = 0; k < 100; ++k) damaged += static_cast<char>(engine());
    files.push_back({"damaged", damaged, "column"});
  }
}

std::vector<Hostile> AllFiles() {
  std::vector<Hostile> files;
  AddFields(files);
  AddRows(files);
  AddHeaders(files);
  AddTimes(files);
  AddEncodings(files);
  return files;
}

void ExpectRefused(const absl::Status& status, const Hostile& file) {
  ASSERT_FALSE(status.ok()) << file.what;
  const std::string message(status.message());
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << message;
  EXPECT_THAT(message, HasSubstr("hostile.csv: line ")) << file.what;
  EXPECT_THAT(message, HasSubstr("column")) << file.what;
  EXPECT_THAT(message, HasSubstr(file.message)) << file.what;
  // What is shown of the file cannot fill a screen or a terminal with codes.
  EXPECT_LT(message.size(), 1000u) << file.what;
  for (const char c : message) {
    EXPECT_FALSE(static_cast<unsigned char>(c) < 0x20) << file.what;
  }
}

TEST(HostileFilesTest, AreRefusedByNameLineAndColumn) {
  const std::vector<Hostile> files = AllFiles();
  EXPECT_GE(files.size(), 300u);
  for (const Hostile& file : files) {
    ExpectRefused(ImportHistorianSources({TextSource("hostile.csv", file.text)},
                                         HostileTank(), {})
                      .status(),
                  file);
  }
}

// Whatever is changed in a good file, it is refused or gives finite samples,
// and nothing crashes.
TEST(HostileFilesTest, AnyDamageIsSurvived) {
  std::mt19937_64 engine(1);
  int taken = 0;
  const std::string alphabet("0123456789,.;\t\n\r\"eE+-NaN \0\xFFtime", 31);
  for (int trial = 0; trial < 20000; ++trial) {
    std::string text = WithField(0, 0, "0");
    const int changes = 1 + static_cast<int>(engine() % 5);
    for (int c = 0; c < changes; ++c) {
      const std::size_t at = engine() % text.size();
      const char byte = alphabet[engine() % alphabet.size()];
      switch (engine() % 3) {
        case 0:
          text[at] = byte;
          break;
        case 1:
          text.insert(at, 1, byte);
          break;
        default:
          text.erase(at, 1 + engine() % 3);
      }
    }
    const auto import =
        ImportHistorianSources({TextSource("hostile.csv", text)}, HostileTank(),
                               {.max_samples = 100000});
    if (!import.ok()) continue;
    ++taken;
    for (const Record& record : import->records) {
      ASSERT_TRUE(record.Validate().ok());
      ASSERT_FALSE(record.outputs.array().isInf().any());
      ASSERT_FALSE(record.inputs.array().isInf().any());
    }
  }
  EXPECT_GT(taken, 1000);  // the others are refused
  EXPECT_LT(taken, 19000);
}

// As many bytes as one likes, without a line's end; counts those taken.
class EndlessLine : public std::streambuf {
 public:
  EndlessLine(std::string start, char fill, std::int64_t size)
      : start_(std::move(start)), block_(1 << 16, fill), size_(size) {}
  std::int64_t taken() const { return taken_; }

 protected:
  int_type underflow() override {
    if (taken_ >= size_) return traits_type::eof();
    std::string& from = taken_ == 0 && !start_.empty() ? start_ : block_;
    setg(from.data(), from.data(), from.data() + from.size());
    taken_ += static_cast<std::int64_t>(from.size());
    return traits_type::to_int_type(from[0]);
  }

 private:
  std::string start_;
  std::string block_;
  std::int64_t size_;
  std::int64_t taken_ = 0;
};

TEST(HostileFilesTest, AnEndlessLineTakesNeitherTimeNorMemory) {
  struct Case {
    std::string start;
    char fill;
    std::string message;
  };
  for (const Case& c :
       {Case{"", 'x', "line 1, column 1: the line is longer than 1048576"},
        Case{"", ',', "line 1, column 10001: there are more than 10000"},
        Case{"\"", 'x', "line 1, column 1: the line is longer than"},
        Case{std::string(kHeader) + "0,1,2,3,4\n1,1,\"", '\n',
             "line 3, column 3: the line is longer than"},
        Case{std::string(kHeader) + "0,1,2,3,4\n1,1,", '7',
             "line 3, column 3: the line is longer than"}}) {
    EndlessLine* last = nullptr;
    std::vector<std::unique_ptr<EndlessLine>> buffers;
    const HistorianSource source = {
        "hostile.csv", [&]() -> absl::StatusOr<std::unique_ptr<std::istream>> {
          buffers.push_back(
              std::make_unique<EndlessLine>(c.start, c.fill, 100'000'000));
          last = buffers.back().get();
          return std::make_unique<std::istream>(last);
        }};
    const absl::Status status =
        ImportHistorianSources({source}, HostileTank(), {}).status();
    EXPECT_THAT(std::string(status.message()),
                HasSubstr("hostile.csv: " + c.message));
    EXPECT_LT(last->taken(), 2'000'000);
  }
}

// Times that would make more samples than there is memory.
TEST(HostileFilesTest, FarTimesMakeNoSamples) {
  const std::string far = WithField(3, 0, "1e15");
  const auto import = ImportHistorianSources(
      {TextSource("a.csv", std::string(far, 0, far.find("\n4,") + 1))},
      HostileTank(), {});
  ASSERT_TRUE(import.ok()) << import.status();
  EXPECT_EQ(import->records.size(), 1u);  // the far row is a record of its own
  EXPECT_EQ(import->report.samples, 3);
  HistorianOptions options;
  options.max_gap = 1e14;
  options.max_samples = 1000;
  const std::string rows =
      std::string(kHeader) +
      "0,1,2,3,4\n1,1,2,3,4\n2,1,2,3,4\n3,1,2,3,4\n1e9,1,2,3,4\n";
  EXPECT_THAT(std::string(ImportHistorianSources({TextSource("a.csv", rows)},
                                                 HostileTank(), options)
                              .status()
                              .message()),
              HasSubstr("more than 1000 samples"));
}

}  // namespace
}  // namespace mle
