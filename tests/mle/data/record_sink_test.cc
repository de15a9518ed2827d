#include "mle/data/record_sink.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "tests/mle/data/historian_texts.h"

namespace mle {
namespace {

// Keeps everything, as it came.
class Pieces final : public RecordSink {
 public:
  int PieceSamples(double sample_time) const override {
    EXPECT_EQ(sample_time, 1.0);
    return 10;
  }
  absl::Status Take(Record piece, bool continues) override {
    if (static_cast<int>(pieces.size()) == refused) {
      return absl::InvalidArgumentError("enough");
    }
    pieces.push_back(piece);
    continuing.push_back(continues);
    return absl::OkStatus();
  }
  std::vector<Record> Finish() override { return {pieces[0]}; }

  int refused = -1;
  std::vector<Record> pieces;
  std::vector<bool> continuing;
};

// `samples` rows by the minute; the level is the minute, steam is missing in
// minutes `from` to `to`, the rows of `absent` are not there.
std::string Rows(int samples, int from, int to, std::pair<int, int> absent) {
  std::string text = "time,steam,level\n";
  for (int k = 0; k < samples; ++k) {
    if (k >= absent.first && k < absent.second) continue;
    absl::StrAppend(&text, k, ",",
                    k >= from && k < to ? "" : absl::StrCat(k % 7), ",", k,
                    "\n");
  }
  return text;
}

absl::StatusOr<HistorianImport> ImportTo(Pieces& pieces,
                                         const std::string& text) {
  HistorianOptions options;
  options.max_samples = 20;
  return ImportHistorianSources({TextSource("a.csv", text)}, Tank(), options,
                                &pieces);
}

TEST(RecordSinkTest, TakesRecordsInPieces) {
  Pieces pieces;
  const auto import = ImportTo(pieces, Rows(61, 0, 0, {35, 50}));
  ASSERT_TRUE(import.ok()) << import.status();
  std::vector<int> samples;
  std::vector<double> starts;
  for (const Record& piece : pieces.pieces) {
    EXPECT_TRUE(piece.Validate().ok());
    EXPECT_EQ(piece.outputs(0, 0), piece.start_time);
    samples.push_back(piece.samples());
    starts.push_back(piece.start_time);
  }
  EXPECT_EQ(samples, (std::vector<int>{10, 10, 10, 5, 10, 1}));
  EXPECT_EQ(starts, (std::vector<double>{0, 10, 20, 30, 50, 60}));
  EXPECT_EQ(pieces.continuing,
            (std::vector<bool>{false, true, true, true, false, true}));
  // More samples than may be held, of which the sink keeps some.
  EXPECT_EQ(import->records.size(), 1);
  EXPECT_EQ(import->report.samples, 46);
  EXPECT_EQ(import->report.kept_samples, 10);
  EXPECT_EQ(import->report.num_gaps, 1);
  EXPECT_NE(import->report.BriefReport().find("46 samples every 1 (10 kept)"),
            std::string::npos)
      << import->report.BriefReport();
}

// A gap that is bridged is bridged whole; a longer one ends a piece at twice
// its samples.
TEST(RecordSinkTest, NoGapLiesAcrossTheEndOfAPiece) {
  Pieces bridged;
  ASSERT_TRUE(ImportTo(bridged, Rows(30, 9, 12, {30, 30})).ok());
  Pieces whole;
  const auto at_once = ImportHistorianSources(
      {TextSource("a.csv", Rows(30, 9, 12, {30, 30}))}, Tank(), {});
  ASSERT_TRUE(at_once.ok());
  ASSERT_EQ(bridged.pieces.size(), 3);
  EXPECT_EQ(bridged.pieces[0].samples(), 13);
  EXPECT_EQ(bridged.pieces[0].inputs, at_once->records[0].inputs.leftCols(13));
  EXPECT_EQ(bridged.pieces[1].inputs,
            at_once->records[0].inputs.middleCols(13, 10));

  Pieces bad;
  ASSERT_TRUE(ImportTo(bad, Rows(40, 8, 38, {40, 40})).ok());
  ASSERT_EQ(bad.pieces.size(), 3);
  EXPECT_EQ(bad.pieces[0].samples(), 20);
  EXPECT_EQ(bad.pieces[1].samples(), 19);
}

TEST(RecordSinkTest, AnErrorEndsTheImport) {
  Pieces pieces;
  pieces.refused = 2;
  const auto import = ImportTo(pieces, Rows(60, 0, 0, {60, 60}));
  EXPECT_EQ(import.status().message(), "enough");
  EXPECT_EQ(pieces.pieces.size(), 2);
}

}  // namespace
}  // namespace mle
