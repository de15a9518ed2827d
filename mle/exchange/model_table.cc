#include "mle/exchange/model_table.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"
#include "mle/exchange/element_columns.h"
#include "mle/exchange/transform_line.h"

namespace mle {
namespace {

constexpr char kKeys[] =
    "name, time unit, input, output, transform, interval, time to steady "
    "state, ramp";

char SeparatorOf(std::string_view text) {
  const std::size_t at = text.find_first_of(",;\t\n");
  return at == std::string_view::npos || text[at] == '\n' ? ',' : text[at];
}

bool IsHeader(const std::vector<std::string>& fields) {
  return FoldedKey(fields.front()) == "time" || IsElementHeader(fields);
}

class ModelTableReader {
 public:
  explicit ModelTableReader(ModelTable& table) : table_(table) {}

  absl::Status Read(std::string_view text);

 private:
  absl::Status CheckUtf8(const TableLine& line) const;
  absl::Status ReadHeadLine(TableLine line);
  absl::Status ReadChannel(const TableLine& line, bool is_input);
  absl::Status ReadTransform(const TableLine& line);
  absl::Status ReadRow(TableLine line);
  absl::Status Finish() const;

  ModelTable& table_;
  std::map<std::string, int> names_;  // of channels, and the line of each
  std::map<std::string, int> keys_;   // that may be given once, likewise
};

// Names are written into JSON, which is UTF-8.
absl::Status ModelTableReader::CheckUtf8(const TableLine& line) const {
  for (std::size_t c = 0; c < line.fields.size(); ++c) {
    if (IsUtf8(line.fields[c])) continue;
    return table_.Fault(
        line, static_cast<int>(c),
        absl::StrCat("'", ShowCsvText(line.fields[c]),
                     "' is not in UTF-8; save the table as CSV UTF-8"));
  }
  return absl::OkStatus();
}

absl::Status ModelTableReader::ReadChannel(const TableLine& line,
                                           bool is_input) {
  const std::vector<std::string>& fields = line.fields;
  if (fields.size() < 2 || fields[1].empty()) {
    return table_.Fault(line.line,
                        absl::StrCat("the ", fields.front(), " has no name"));
  }
  const auto [found, is_new] = names_.emplace(fields[1], line.line);
  if (!is_new) {
    return table_.Fault(
        line.line, absl::StrCat("the name '", ShowCsvText(fields[1]),
                                "' stands in line ", found->second,
                                " already; names of inputs and outputs must "
                                "differ"));
  }
  const std::string unit = fields.size() > 2 ? fields[2] : "";
  const std::string role = fields.size() > 3 ? FoldedKey(fields[3]) : "";
  const bool role_fits =
      role.empty() ||
      (is_input && (role == "manipulated" || role == "disturbance"));
  if (!role_fits || fields.size() > 4) {
    return table_.Fault(line.line,
                        is_input ? "after name and unit an input may have "
                                   "'manipulated' or 'disturbance' alone"
                                 : "an output has a name and a unit alone");
  }
  if (is_input) {
    table_.inputs.push_back({fields[1], unit,
                             role == "disturbance" ? InputRole::kDisturbance
                                                   : InputRole::kManipulated});
  } else {
    table_.outputs.push_back({fields[1], unit});
  }
  return absl::OkStatus();
}

absl::Status ModelTableReader::ReadTransform(const TableLine& line) {
  MLE_ASSIGN_OR_RETURN(Transform transform, ReadTransformLine(table_, line));
  Transform* given = nullptr;
  const auto find = [&](auto& channels) {
    for (auto& channel : channels) {
      if (channel.name == line.fields[1]) given = &channel.transform;
    }
  };
  find(table_.inputs);
  find(table_.outputs);
  const std::string name = ShowCsvText(line.fields[1]);
  if (given == nullptr) {
    return table_.Fault(line.line,
                        absl::StrCat("the transform is of '", name,
                                     "', which no line of an input or output "
                                     "above names"));
  }
  if (!given->IsNone()) {
    return table_.Fault(line.line,
                        absl::StrCat("a second transform of '", name, "'"));
  }
  *given = std::move(transform);
  return absl::OkStatus();
}

absl::Status ModelTableReader::ReadHeadLine(TableLine line) {
  line.fields.front() = FoldedKey(line.fields.front());
  const std::string key = line.fields.front();  // the fields may grow
  if (key == "input" || key == "output") {
    return ReadChannel(line, key == "input");
  }
  if (key == "transform") return ReadTransform(line);
  if (key == "ramp") {
    table_.others.push_back(std::move(line));
    return absl::OkStatus();
  }
  if (key != "name" && key != "time unit" && key != "interval" &&
      key != "time to steady state") {
    return table_.Fault(
        line.line,
        absl::StrCat("'", ShowCsvText(key),
                     "' is not known; a line above the "
                     "table begins with one of ",
                     kKeys,
                     ", and the table with a header whose first field is "
                     "'time' (step responses) or that has the fields output, "
                     "input and gain"));
  }
  const auto [found, is_new] = keys_.emplace(key, line.line);
  if (!is_new) {
    return table_.Fault(line.line, absl::StrCat("'", key, "' stands in line ",
                                                found->second, " already"));
  }
  if (key == "name")
    line.fields.resize(std::max<std::size_t>(line.fields.size(), 2));
  if (line.fields.size() != 2) {
    return table_.Fault(line.line,
                        absl::StrCat("'", key, "' has ", line.fields.size() - 1,
                                     " values, must have one"));
  }
  if (key == "name") {
    table_.name = line.fields[1];
  } else if (key == "time unit") {
    table_.time_unit = line.fields[1];
  } else {
    table_.others.push_back(std::move(line));
  }
  return absl::OkStatus();
}

absl::Status ModelTableReader::ReadRow(TableLine line) {
  const std::size_t width = table_.header.fields.size();
  if (line.fields.size() > width) {
    return table_.Fault(line.line,
                        absl::StrCat("the row has ", line.fields.size(),
                                     " fields, the header in line ",
                                     table_.header.line, " has ", width));
  }
  line.fields.resize(width);
  table_.rows.push_back(std::move(line));
  return absl::OkStatus();
}

absl::Status ModelTableReader::Finish() const {
  if (table_.header.fields.empty()) {
    return InvalidArgument(
        table_.source,
        ": there is no table: a header whose first field is 'time' (step "
        "responses) or that has the fields output, input and gain, and rows "
        "below it");
  }
  if (table_.time_unit.empty()) {
    return table_.Fault(table_.header.line,
                        "the table begins, but no line above it has the unit "
                        "of time, such as 'time unit,min', nor have the "
                        "columns of times the same in brackets (Tau (min))");
  }
  if (table_.inputs.empty() != table_.outputs.empty()) {
    return table_.Fault(
        table_.header.line,
        absl::StrCat("the lines above the table name no ",
                     table_.inputs.empty() ? "input" : "output",
                     "; name all inputs and outputs there, or none"));
  }
  if (table_.rows.empty()) {
    return table_.Fault(table_.header.line, "no row follows the header");
  }
  return absl::OkStatus();
}

absl::Status ModelTableReader::Read(std::string_view text) {
  table_.separator = SeparatorOf(text);
  std::istringstream in{std::string(text)};
  CsvRows rows(in, table_.source);
  rows.set_separator(table_.separator);
  std::vector<std::string_view> fields;
  while (rows.Next(fields)) {
    TableLine line{rows.line(), {}};
    for (const std::string_view field : fields) {
      line.fields.emplace_back(TrimCsvField(field));
    }
    MLE_RETURN_IF_ERROR(CheckUtf8(line));
    while (!line.fields.empty() && line.fields.back().empty()) {
      line.fields.pop_back();
    }
    if (line.fields.empty()) continue;
    if (!table_.header.fields.empty()) {
      MLE_RETURN_IF_ERROR(ReadRow(std::move(line)));
    } else if (IsHeader(line.fields)) {
      table_.header = std::move(line);
      if (table_.time_unit.empty()) {
        table_.time_unit = TimeUnitInHeader(table_.header.fields);
      }
    } else {
      MLE_RETURN_IF_ERROR(ReadHeadLine(std::move(line)));
    }
  }
  MLE_RETURN_IF_ERROR(rows.status());
  return Finish();
}

}  // namespace

absl::Status ModelTable::Fault(int line, std::string_view what) const {
  return InvalidArgument(source, ": line ", line, ": ", std::string(what));
}

absl::Status ModelTable::Fault(const TableLine& row, int column,
                               std::string_view what) const {
  return InvalidArgument(source, ": line ", row.line, ", column ", column + 1,
                         ": ", std::string(what));
}

absl::StatusOr<double> ModelTable::Number(const TableLine& row,
                                          int column) const {
  const std::string& field = row.fields[column];
  if (field.empty()) {
    return Fault(row, column, "the field is empty, must be a number");
  }
  const bool comma = separator != ',' && field.find(',') != std::string::npos;
  double number = 0.0;
  if (!ReadCsvNumber(field, number, comma ? ',' : '.') ||
      !std::isfinite(number)) {
    return Fault(row, column,
                 absl::StrCat("'", ShowCsvText(field),
                              "' is not a number, or is out of range"));
  }
  return number;
}

absl::StatusOr<ProcessModel> ModelTable::Channels(
    const std::vector<PairOfNames>& pairs) const {
  std::vector<InputChannel> its_inputs = inputs;
  std::vector<OutputChannel> its_outputs = outputs;
  const bool named = !inputs.empty();
  const auto has = [](const auto& channels, const std::string& channel) {
    return std::any_of(channels.begin(), channels.end(),
                       [&](const auto& one) { return one.name == channel; });
  };
  for (const PairOfNames& pair : pairs) {
    if (named) break;
    if (!has(its_inputs, pair.input)) its_inputs.push_back({pair.input, ""});
    if (!has(its_outputs, pair.output)) {
      its_outputs.push_back({pair.output, ""});
    }
  }
  ProcessModel model(name, time_unit, std::move(its_inputs),
                     std::move(its_outputs));
  if (const absl::Status status = model.Validate(); !status.ok()) {
    return Fault(header.line, std::string(status.message()));
  }
  return model;
}

absl::StatusOr<ModelTable> ReadModelTable(std::string_view text,
                                          std::string_view source) {
  ModelTable table;
  table.source = std::string(source);
  table.name = std::filesystem::path(table.source).stem().string();
  MLE_RETURN_IF_ERROR(ModelTableReader(table).Read(text));
  return table;
}

std::string FormatTableHead(const ProcessModel& channels) {
  std::string text =
      absl::StrCat("name,", QuoteCsvField(channels.name()), "\ntime unit,",
                   QuoteCsvField(channels.time_unit()), "\n");
  for (const InputChannel& input : channels.inputs()) {
    absl::StrAppend(
        &text, "input,", QuoteCsvField(input.name), ",",
        QuoteCsvField(input.unit),
        input.role == InputRole::kDisturbance ? ",disturbance\n" : "\n");
  }
  for (const OutputChannel& output : channels.outputs()) {
    absl::StrAppend(&text, "output,", QuoteCsvField(output.name), ",",
                    QuoteCsvField(output.unit), "\n");
  }
  for (const InputChannel& input : channels.inputs()) {
    text += FormatTransformLine(input.name, input.transform);
  }
  for (const OutputChannel& output : channels.outputs()) {
    text += FormatTransformLine(output.name, output.transform);
  }
  return text;
}

std::string TableNumber(double number) {
  std::string text;
  AppendCsvNumber(number, text);
  return text;
}

}  // namespace mle
