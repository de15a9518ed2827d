// Parts of a page that can be operated: fields that filter a table, and forms.

#ifndef APPS_REPORT_CONTROLS_H_
#define APPS_REPORT_CONTROLS_H_

#include <string>
#include <string_view>
#include <vector>

#include "apps/report/table.h"

namespace mle::report {

// A form that a server takes by POST; of no use in a page that is a file.
struct Form {
  std::string action = {};  // path on the server that the page came from
  std::string submit = {};  // on the button
  struct Field {
    std::string name = {};
    std::string label = {};
    enum class Kind { kText, kPassword, kHidden };
    Kind kind = Kind::kText;
    std::string value = {};
    std::string autocomplete = "off";  // as HTML has it: "username"
    int most_characters = 200;
    bool required = false;
  };
  std::vector<Field> fields = {};
};

std::string RenderForm(const Form& form);

// `content`, which holds the table, below the fields that filter it. Without
// scripts the fields are not shown.
std::string RenderFilter(const Table& table, std::string_view content);

// The handler in the markup, unescaped.
std::string_view FilterScript();

}  // namespace mle::report

#endif  // APPS_REPORT_CONTROLS_H_
