// Rows of a database as the text that the importer reads: a header, commas, a
// row in each line. Internal to mle/database.
//
//   TableText text;
//   text.AddName("time"); text.AddName("TI\"101"); text.EndRow();
//   text.Add("2024-03-04 06:00"); text.Add(71.3); text.EndRow();
//   text.text();   // "time","TI""101"\n2024-03-04 06:00,71.3\n
//
// A text cannot leave its field, nor its line: line breaks and tabs become
// blanks, other control characters are written as \x00.

#ifndef MLE_DATABASE_TABLE_TEXT_H_
#define MLE_DATABASE_TABLE_TEXT_H_

#include <cstdint>
#include <string>
#include <string_view>

namespace mle {

class TableText {
 public:
  // In quotes, whatever it is, so that no header is taken for the beginning of
  // another kind of file.
  void AddName(std::string_view name);
  void Add(std::string_view value);
  void Add(std::int64_t value);
  // With as many digits as make it the same number again.
  void Add(double value);
  void AddNull();
  void EndRow();

  const std::string& text() const { return text_; }
  char* data() { return text_.data(); }
  // Keeps its memory.
  void Clear() { text_.clear(); }

 private:
  void Separate();
  void AddQuoted(std::string_view value);

  std::string text_;
  bool is_first_ = true;  // field of its row
};

}  // namespace mle

#endif  // MLE_DATABASE_TABLE_TEXT_H_
