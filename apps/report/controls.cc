#include "apps/report/controls.h"

#include <cstddef>
#include <cstdint>
#include <set>

#include "apps/report/number.h"
#include "apps/report/text.h"

namespace mle::report {
namespace {

// Hides the rows that do not hold the text, in any case of letters, or have
// another value in the column of the list, and says how many are left.
constexpr std::string_view kFilter =
    "const q=this.querySelector('input').value.trim().toLowerCase(),c=this."
    "querySelector('select'),b=this.querySelector('table').tBodies[0];let n=0;"
    "for(const r of b.rows){r.hidden=!(r.textContent.toLowerCase().includes(q)"
    "&&(!c||!c.value||r.cells[+c.dataset.column].textContent===c.value));"
    "n+=!r.hidden}this.querySelector('output').textContent=n.toLocaleString("
    "'en')+' of '+b.rows.length.toLocaleString('en')";

// The values of the column.
std::set<std::string> ValuesOf(const Table& table, std::size_t column) {
  std::set<std::string> values;
  for (const auto& row : table.rows) {
    if (column < row.size()) values.insert(row[column]);
  }
  return values;
}

std::string RenderChoice(const Table& table) {
  if (table.choice < 0 ||
      static_cast<std::size_t>(table.choice) >= table.columns.size()) {
    return "";
  }
  const auto column = static_cast<std::size_t>(table.choice);
  std::string out = "<label>" + EscapeHtml(table.columns[column].header) +
                    " <select data-column=\"" + std::to_string(column) +
                    "\"><option value=\"\">all</option>";
  for (const std::string& value : ValuesOf(table, column)) {
    out += "<option>" + EscapeHtml(value) + "</option>";
  }
  return out + "</select></label>\n";
}

std::string_view TypeOf(Form::Field::Kind kind) {
  switch (kind) {
    case Form::Field::Kind::kPassword:
      return "password";
    case Form::Field::Kind::kHidden:
      return "hidden";
    case Form::Field::Kind::kText:
      break;
  }
  return "text";
}

std::string RenderField(const Form::Field& field) {
  std::string input = "<input type=\"";
  input += TypeOf(field.kind);
  input += "\" name=\"" + EscapeHtml(field.name) + "\"";
  if (!field.value.empty()) {
    input += " value=\"" + EscapeHtml(field.value) + "\"";
  }
  if (field.kind == Form::Field::Kind::kHidden) return input + ">\n";
  input += " autocomplete=\"" + EscapeHtml(field.autocomplete) + "\"";
  input += " maxlength=\"" + std::to_string(field.most_characters) + "\"";
  if (field.required) input += " required=\"required\"";
  return "<label>" + EscapeHtml(field.label) + " " + input + "></label>\n";
}

}  // namespace

std::string RenderForm(const Form& form) {
  std::string out =
      "<form method=\"post\" action=\"" + EscapeHtml(form.action) + "\">\n";
  for (const Form::Field& field : form.fields) out += RenderField(field);
  return out + "<button type=\"submit\">" + EscapeHtml(form.submit) +
         "</button>\n</form>\n";
}

std::string RenderFilter(const Table& table, std::string_view content) {
  std::string out = "<div class=\"filtered\" oninput=\"";
  out += EscapeHtml(kFilter) + "\">\n<div class=\"filter\">\n";
  out += "<label>Search <input type=\"search\"></label>\n";
  out += RenderChoice(table);
  const std::string rows =
      FormatInteger(static_cast<std::int64_t>(table.rows.size()));
  out += "<output>" + rows + " of " + rows + "</output>\n</div>\n";
  out += content;
  return out + "</div>\n";
}

std::string_view FilterScript() { return kFilter; }

}  // namespace mle::report
