
#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "mle/base/status.h"
#include "mle/data/civil_time.h"
#include "mle/data/csv_rows.h"
#include "mle/exchange/element_columns.h"
#include "mle/exchange/step_response_text.h"

namespace mle {
namespace {

// "output, input, gain, …"
std::string KnownColumns() {
  std::vector<std::string> names;
  for (int c = 0; c < kNumElementColumns; ++c) {
    names.emplace_back(NameOf(static_cast<ElementColumn>(c)));
  }
  return absl::StrJoin(names, ", ");
}

class TableReader {
 public:
  explicit TableReader(const ModelTable& table) : table_(table) {}

  absl::StatusOr<ElementTable> Read();

 private:
  absl::Status ReadHeader();
  // That a column of times is in the unit of the file.
  absl::Status CheckUnit(ElementColumn column, int place) const;
  absl::Status ReadRow(const TableLine& line);
  bool Has(ElementColumn column) const { return columns_[column] >= 0; }
  const std::string& Field(const TableLine& line, ElementColumn column) const {
    return line.fields[columns_[column]];
  }
  // `otherwise` where the column or the field is not there.
  absl::StatusOr<double> Number(const TableLine& line, ElementColumn column,
                                std::optional<double> otherwise) const;
  absl::StatusOr<bool> Integrates(const TableLine& line) const;
  template <typename Channel>
  absl::StatusOr<int> Find(const TableLine& line, ElementColumn column,
                           const std::vector<Channel>& channels) const;

  const ModelTable& table_;
  std::array<int, kNumElementColumns> columns_{};
  std::vector<int> lines_;  // of the rows
  ElementTable result_;
};

absl::Status TableReader::ReadHeader() {
  columns_.fill(-1);
  for (std::size_t c = 0; c < table_.header.fields.size(); ++c) {
    const std::optional<ElementColumn> column =
        ElementColumnOf(table_.header.fields[c]);
    const std::string shown = ShowCsvText(table_.header.fields[c]);
    if (IsDampingField(table_.header.fields[c])) {
      return table_.Fault(
          table_.header, static_cast<int>(c),
          absl::StrCat(
              "'", shown,
              "' is a damping, of which a table of elements has none: give the "
              "model in JSON, where K, tau and zeta are \"numerator\": [K], "
              "\"denominator\": [tau^2, 2 zeta tau, 1] (docs/formats.md)"));
    }
    if (!column.has_value()) {
      return table_.Fault(
          table_.header, static_cast<int>(c),
          absl::StrCat("'", shown,
                       "' is not a column of the table; choose from ",
                       KnownColumns()));
    }
    if (columns_[*column] >= 0) {
      return table_.Fault(table_.header, static_cast<int>(c),
                          absl::StrCat("'", shown, "' stands in column ",
                                       columns_[*column] + 1, " already"));
    }
    columns_[*column] = static_cast<int>(c);
    MLE_RETURN_IF_ERROR(CheckUnit(*column, static_cast<int>(c)));
  }
  for (const ElementColumn needed : {kTimeConstantColumn, kDelayColumn}) {
    if (Has(needed)) continue;
    return table_.Fault(
        table_.header.line,
        absl::StrCat("the header has no column '", NameOf(needed), "'"));
  }
  result_.has_second = Has(kSecondColumn);
  result_.has_lead = Has(kLeadColumn);
  result_.has_integrating = Has(kIntegratingColumn);
  return absl::OkStatus();
}

absl::Status TableReader::CheckUnit(ElementColumn column, int place) const {
  if (!IsTimeColumn(column)) return absl::OkStatus();
  const std::string unit = UnitInHeader(table_.header.fields[place]);
  const std::optional<double> here = SecondsPerUnit(unit);
  // Other text in brackets may be no unit: "T1 (lag)".
  if (!here.has_value() || here == SecondsPerUnit(table_.time_unit)) {
    return absl::OkStatus();
  }
  return table_.Fault(table_.header, place,
                      absl::StrCat("the ", NameOf(column), " is in '", unit,
                                   "', but the time unit of the file is '",
                                   ShowCsvText(table_.time_unit),
                                   "'; all times must be in that unit"));
}

absl::StatusOr<double> TableReader::Number(
    const TableLine& line, ElementColumn column,
    std::optional<double> otherwise) const {
  if (otherwise.has_value() && (!Has(column) || Field(line, column).empty())) {
    return *otherwise;
  }
  return table_.Number(line, columns_[column]);
}

template <typename Channel>
absl::StatusOr<int> TableReader::Find(
    const TableLine& line, ElementColumn column,
    const std::vector<Channel>& channels) const {
  const std::string& name = Field(line, column);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (channels[i].name == name) return static_cast<int>(i);
  }
  return table_.Fault(
      line, columns_[column],
      absl::StrCat("'", ShowCsvText(name), "' is unknown; the ", NameOf(column),
                   "s are ",
                   absl::StrJoin(channels, ", ",
                                 [](std::string* out, const Channel& channel) {
                                   absl::StrAppend(out, channel.name);
                                 })));
}

absl::StatusOr<bool> TableReader::Integrates(const TableLine& line) const {
  if (!Has(kIntegratingColumn)) return false;
  const std::string& field = Field(line, kIntegratingColumn);
  if (const std::optional<bool> yes = IsIntegratingField(field)) return *yes;
  return table_.Fault(line, columns_[kIntegratingColumn],
                      absl::StrCat("'", ShowCsvText(field),
                                   "' is neither 'yes' (the element "
                                   "integrates) nor 'no' or empty"));
}

absl::Status TableReader::ReadRow(const TableLine& line) {
  ElementRow row;
  MLE_ASSIGN_OR_RETURN(row.output,
                       Find(line, kOutputColumn, result_.channels.outputs()));
  MLE_ASSIGN_OR_RETURN(row.input,
                       Find(line, kInputColumn, result_.channels.inputs()));
  for (std::size_t r = 0; r < result_.rows.size(); ++r) {
    const ElementRow& other = result_.rows[r];
    if (other.output != row.output || other.input != row.input) continue;
    return table_.Fault(
        line.line,
        absl::StrCat(
            "the pair ", PairName(result_.channels, row.output, row.input),
            " stands in line ", lines_[r], " already; give each pair once"));
  }
  MLE_ASSIGN_OR_RETURN(row.gain, Number(line, kGainColumn, std::nullopt));
  MLE_ASSIGN_OR_RETURN(row.integrating, Integrates(line));
  // An integrator without lag has none to be written.
  const auto no_lag = row.integrating ? std::optional(0.0) : std::nullopt;
  MLE_ASSIGN_OR_RETURN(row.time_constant,
                       Number(line, kTimeConstantColumn, no_lag));
  MLE_ASSIGN_OR_RETURN(row.second_time_constant,
                       Number(line, kSecondColumn, 0.0));
  MLE_ASSIGN_OR_RETURN(row.lead, Number(line, kLeadColumn, 0.0));
  MLE_ASSIGN_OR_RETURN(row.delay, Number(line, kDelayColumn, std::nullopt));
  for (const auto& [column, value] :
       {std::pair(kTimeConstantColumn, row.time_constant),
        std::pair(kSecondColumn, row.second_time_constant),
        std::pair(kDelayColumn, row.delay)}) {
    if (value >= 0.0) continue;
    return table_.Fault(line, columns_[column],
                        absl::StrCat("the ", NameOf(column), " is ", value,
                                     ", must not be negative"));
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
    names.push_back({Field(line, kOutputColumn), Field(line, kInputColumn)});
  }
  MLE_ASSIGN_OR_RETURN(result_.channels, table_.Channels(names));
  for (const TableLine& line : table_.rows) {
    MLE_RETURN_IF_ERROR(ReadRow(line));
  }
  return std::move(result_);
}

}  // namespace

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
                  table.has_integrating ? ",integrating" : "",
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
    if (table.has_integrating) text += row.integrating ? ",yes" : ",";
    if (inexact) {
      absl::StrAppend(&text, ",", TableNumber(row.largest_difference));
    }
    text += '\n';
  }
  return text;
}

}  // namespace mle
