#include "mle/exchange/element_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/exchange/description.h"
#include "mle/exchange/element_csv.h"
#include "mle/exchange/model_table.h"
#include "mle/exchange/step_response_csv.h"
#include "mle/nonlinear/fopdt_fit.h"
#include "mle/nonlinear/sopdt_fit.h"

namespace mle {
namespace {

enum Column {
  kOutput,
  kInput,
  kGain,
  kTimeConstant,
  kSecond,
  kLead,
  kDelay,
  kDifference,  // what the program writes; it is not read
  kNumColumns
};

constexpr std::array<const char*, kNumColumns> kColumnNames = {
    "output",
    "input",
    "gain",
    "time constant",
    "second time constant",
    "lead",
    "dead time",
    "largest difference"};

int FindColumn(const std::string& name) {
  const std::string key = FoldedKey(name);
  if (key == "delay") return kDelay;
  const auto found = std::find(kColumnNames.begin(), kColumnNames.end(), key);
  return found == kColumnNames.end()
             ? -1
             : static_cast<int>(found - kColumnNames.begin());
}

constexpr int kResponseSamples = 400;
// Of the square of the sum of two time constants: their difference, squared,
// that rounding makes negative.
constexpr double kRounding = 1e-12;

bool SameElement(const TransferFunction& a, const TransferFunction& b) {
  return a.numerator() == b.numerator() && a.denominator() == b.denominator() &&
         a.delay() == b.delay();
}

// T and T₂ of T T₂ s² + (T + T₂) s + 1, the larger first.
std::optional<std::pair<double, double>> Lags(const TransferFunction& g) {
  const std::vector<double>& a = g.denominator();
  if (a.size() > 3) return std::nullopt;
  const double one = a.back();
  const double sum = a.size() > 1 ? a[a.size() - 2] / one : 0.0;
  const double product = a.size() > 2 ? a.front() / one : 0.0;
  const double square = sum * sum - 4.0 * product;
  if (square < -kRounding * sum * sum) return std::nullopt;
  const double larger = 0.5 * (sum + std::sqrt(std::max(square, 0.0)));
  return std::pair(larger, larger > 0.0 ? product / larger : 0.0);
}

// The row that is the element; nothing where none is.
std::optional<ElementRow> ExactRow(const TransferFunction& g) {
  const auto lags = Lags(g);
  std::vector<double> b = g.numerator();
  while (b.size() > 1 && b.front() == 0.0) b.erase(b.begin());
  if (!lags.has_value() || b.size() > 2 || b.back() == 0.0) {
    return std::nullopt;
  }
  ElementRow row;
  row.gain = g.StaticGain();
  row.time_constant = lags->first;
  row.second_time_constant = lags->second;
  row.lead = b.size() == 2 ? b.front() / b.back() : 0.0;
  row.delay = g.delay();
  return row;
}

double DifferenceOf(const ElementRow& row, const Eigen::VectorXd& response,
                    double sample_time) {
  return (row.Element().StepResponse(sample_time,
                                     static_cast<int>(response.size())) -
          response)
             .cwiseAbs()
             .maxCoeff() /
         RangeOf(response);
}

// The nearer of first and second order without lead; of second order only
// where both poles are real.
ElementRow NearestRow(const TransferFunction& g) {
  const double horizon = g.delay() + 5.0 * g.SlowestTimeConstant();
  const double sample_time = horizon / (kResponseSamples - 1);
  const Eigen::VectorXd response =
      g.StepResponse(sample_time, kResponseSamples);
  ElementRow best;
  best.largest_difference = std::numeric_limits<double>::infinity();
  const auto take = [&](ElementRow row) {
    row.largest_difference = DifferenceOf(row, response, sample_time);
    if (row.largest_difference < best.largest_difference) best = row;
  };
  if (const auto fit = FitFopdt(response, sample_time, {}); fit.ok()) {
    take({0, 0, fit->gain, fit->time_constant, 0.0, 0.0, fit->delay});
  }
  if (const auto fit = FitSopdt(response, sample_time, horizon); fit.ok()) {
    const double t = fit->time_constant;
    const double zeta = std::max(fit->damping, 1.0);
    const double root = std::sqrt(zeta * zeta - 1.0);
    take({0, 0, fit->gain, t * (zeta + root), t * (zeta - root), 0.0,
          fit->delay});
  }
  return best;
}

class TableReader {
 public:
  explicit TableReader(const ModelTable& table) : table_(table) {}

  absl::StatusOr<ElementTable> Read();

 private:
  absl::Status ReadHeader();
  absl::Status ReadRow(const TableLine& line);
  bool Has(Column column) const { return columns_[column] >= 0; }
  const std::string& Field(const TableLine& line, Column column) const {
    return line.fields[columns_[column]];
  }
  // `otherwise` where the column or the field is not there.
  absl::StatusOr<double> Number(const TableLine& line, Column column,
                                std::optional<double> otherwise) const;
  template <typename Channel>
  absl::StatusOr<int> Find(const TableLine& line, Column column,
                           const std::vector<Channel>& channels) const;

  const ModelTable& table_;
  std::array<int, kNumColumns> columns_{};
  std::vector<int> lines_;  // of the rows
  ElementTable result_;
};

absl::Status TableReader::ReadHeader() {
  columns_.fill(-1);
  for (std::size_t c = 0; c < table_.header.fields.size(); ++c) {
    const int column = FindColumn(table_.header.fields[c]);
    const std::string shown = ShowCsvText(table_.header.fields[c]);
    if (column < 0) {
      return table_.Fault(
          table_.header, static_cast<int>(c),
          absl::StrCat("'", shown, "' is not a column of the table; known are ",
                       absl::StrJoin(kColumnNames, ", ")));
    }
    if (columns_[column] >= 0) {
      return table_.Fault(table_.header, static_cast<int>(c),
                          absl::StrCat("'", shown, "' stands in column ",
                                       columns_[column] + 1, " already"));
    }
    columns_[column] = static_cast<int>(c);
  }
  for (const Column needed : {kTimeConstant, kDelay}) {
    if (Has(needed)) continue;
    return table_.Fault(
        table_.header.line,
        absl::StrCat("the header has no column '", kColumnNames[needed], "'"));
  }
  result_.has_second = Has(kSecond);
  result_.has_lead = Has(kLead);
  return absl::OkStatus();
}

absl::StatusOr<double> TableReader::Number(
    const TableLine& line, Column column,
    std::optional<double> otherwise) const {
  if (otherwise.has_value() && (!Has(column) || Field(line, column).empty())) {
    return *otherwise;
  }
  return table_.Number(line, columns_[column]);
}

template <typename Channel>
absl::StatusOr<int> TableReader::Find(
    const TableLine& line, Column column,
    const std::vector<Channel>& channels) const {
  const std::string& name = Field(line, column);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name == name) return static_cast<int>(i);
  }
  return table_.Fault(
      line, columns_[column],
      absl::StrCat("'", ShowCsvText(name), "' is unknown; the ",
                   kColumnNames[column], "s are ",
                   absl::StrJoin(channels, ", ",
                                 [](std::string* out, const Channel& channel) {
                                   absl::StrAppend(out, channel.name);
                                 })));
}

absl::Status TableReader::ReadRow(const TableLine& line) {
  ElementRow row;
  MLE_ASSIGN_OR_RETURN(row.output,
                       Find(line, kOutput, result_.channels.outputs()));
  MLE_ASSIGN_OR_RETURN(row.input,
                       Find(line, kInput, result_.channels.inputs()));
  for (std::size_t r = 0; r < result_.rows.size(); ++r) {
    const ElementRow& other = result_.rows[r];
    if (other.output != row.output || other.input != row.input) continue;
    return table_.Fault(
        line.line,
        absl::StrCat("the pair ",
                     PairName(result_.channels, row.output, row.input),
                     " stands in line ", lines_[r],
                     " already; each pair may stand once"));
  }
  MLE_ASSIGN_OR_RETURN(row.gain, Number(line, kGain, std::nullopt));
  MLE_ASSIGN_OR_RETURN(row.time_constant,
                       Number(line, kTimeConstant, std::nullopt));
  MLE_ASSIGN_OR_RETURN(row.second_time_constant, Number(line, kSecond, 0.0));
  MLE_ASSIGN_OR_RETURN(row.lead, Number(line, kLead, 0.0));
  MLE_ASSIGN_OR_RETURN(row.delay, Number(line, kDelay, std::nullopt));
  for (const auto& [column, value] :
       {std::pair(kTimeConstant, row.time_constant),
        std::pair(kSecond, row.second_time_constant),
        std::pair(kDelay, row.delay)}) {
    if (value >= 0.0) continue;
    return table_.Fault(line, columns_[column],
                        absl::StrCat("the ", kColumnNames[column], " is ",
                                     value, ", must not be negative"));
  }
  if (const absl::Status status = row.Element().Validate(); !status.ok()) {
    return table_.Fault(line.line, std::string(status.message()));
  }
  result_.rows.push_back(row);
  lines_.push_back(line.line);
  return absl::OkStatus();
}

absl::StatusOr<ElementTable> TableReader::Read() {
  MLE_RETURN_IF_ERROR(ReadHeader());
  for (const TableLine& line : table_.others) {
    return table_.Fault(line.line,
                        absl::StrCat("'", line.fields.front(),
                                     "' belongs to tables of step responses"));
  }
  std::vector<ModelTable::PairOfNames> names;
  for (const TableLine& line : table_.rows) {
    names.push_back({Field(line, kOutput), Field(line, kInput)});
  }
  MLE_ASSIGN_OR_RETURN(result_.channels, table_.Channels(names));
  for (const TableLine& line : table_.rows) {
    MLE_RETURN_IF_ERROR(ReadRow(line));
  }
  return std::move(result_);
}

}  // namespace

TransferFunction ElementRow::Element() const {
  std::vector<double> denominator = {1.0};
  for (const double lag : {time_constant, second_time_constant}) {
    if (lag == 0.0) continue;
    std::vector<double> product(denominator.size() + 1, 0.0);
    for (std::size_t i = 0; i < denominator.size(); ++i) {
      product[i] += lag * denominator[i];
      product[i + 1] += denominator[i];
    }
    denominator = std::move(product);
  }
  std::vector<double> numerator = {gain};
  if (lead != 0.0) numerator = {gain * lead, gain};
  return TransferFunction(std::move(numerator), std::move(denominator), delay);
}

ProcessModel ElementTable::Process() const {
  ProcessModel process = channels;
  for (const ElementRow& row : rows) {
    process.element(row.output, row.input) = row.Element();
  }
  return process;
}

absl::StatusOr<ElementTable> ElementsOf(const ModelTable& table) {
  return TableReader(table).Read();
}

absl::StatusOr<ElementTable> ParseElementTable(std::string_view csv,
                                               std::string_view source) {
  MLE_ASSIGN_OR_RETURN(const ModelTable table, ReadModelTable(csv, source));
  if (!HoldsStepResponses(table)) return ElementsOf(table);
  return table.Fault(table.header.line,
                     "the header has no field 'gain': this is not a table of "
                     "elements");
}

std::string FormatElementTable(const ElementTable& table) {
  const bool inexact = std::any_of(
      table.rows.begin(), table.rows.end(),
      [](const ElementRow& r) { return r.largest_difference > 0.0; });
  const auto optional = [](double value) {
    return value == 0.0 ? std::string() : TableNumber(value);
  };
  std::string text = FormatTableHead(table.channels);
  absl::StrAppend(&text, "output,input,gain,time constant",
                  table.has_second ? ",second time constant" : "",
                  table.has_lead ? ",lead" : "", ",dead time",
                  inexact ? ",largest difference\n" : "\n");
  for (const ElementRow& row : table.rows) {
    absl::StrAppend(
        &text, QuoteCsvField(table.channels.outputs()[row.output].name), ",",
        QuoteCsvField(table.channels.inputs()[row.input].name), ",",
        TableNumber(row.gain), ",", TableNumber(row.time_constant));
    if (table.has_second) {
      absl::StrAppend(&text, ",", optional(row.second_time_constant));
    }
    if (table.has_lead) absl::StrAppend(&text, ",", optional(row.lead));
    absl::StrAppend(&text, ",", TableNumber(row.delay));
    if (inexact) {
      absl::StrAppend(&text, ",", TableNumber(row.largest_difference));
    }
    text += '\n';
  }
  return text;
}

ElementTable WithElements(const ElementTable& table,
                          const ProcessModel& corrected) {
  ElementTable changed = table;
  const ProcessModel before = table.Process();
  for (int i = 0; i < corrected.num_outputs(); ++i) {
    for (int j = 0; j < corrected.num_inputs(); ++j) {
      const TransferFunction& g = corrected.element(i, j);
      if (SameElement(g, before.element(i, j))) continue;
      const auto found = std::find_if(
          changed.rows.begin(), changed.rows.end(), [&](const ElementRow& row) {
            return row.output == i && row.input == j;
          });
      if (found == changed.rows.end() && g.IsZero()) continue;
      ElementRow row;
      if (!g.IsZero()) {
        const std::optional<ElementRow> exact = ExactRow(g);
        row = exact.has_value() ? *exact : NearestRow(g);
      }
      row.output = i;
      row.input = j;
      changed.has_second |= row.second_time_constant > 0.0;
      changed.has_lead |= row.lead != 0.0;
      if (found == changed.rows.end()) {
        changed.rows.push_back(row);
        continue;
      }
      if (found->second_time_constant > found->time_constant) {
        std::swap(row.time_constant, row.second_time_constant);
      }
      *found = row;
    }
  }
  return changed;
}

}  // namespace mle
