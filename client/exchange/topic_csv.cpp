#include "client/exchange/topic_csv.h"

#include <array>
#include <charconv>
#include <string_view>

#include "assets/base/utc_time.h"

namespace tandem::client {
namespace {

constexpr const char* kHeader =
    "guid,type,status,title,description,author,created,modified,assigned_to,parts,comments,thread,"
    "place_x_m,place_y_m,place_z_m,camera_x_m,camera_y_m,camera_z_m,direction_x,direction_y,direction_z\r\n";

/// Whether a spreadsheet may read the text as a formula: by its first character, which may be a full-width
/// one of East Asian scripts, after any space.
bool looksLikeFormula(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(' ');
  if (begin == std::string_view::npos) return false;
  text.remove_prefix(begin);
  constexpr std::array<std::string_view, 10> kBeginnings{
      "=", "+", "-", "@", "\t", "\r", "\xef\xbc\x9d", "\xef\xbc\x8b", "\xef\xbc\x8d", "\xef\xbc\xa0"};
  for (const std::string_view beginning : kBeginnings)
    if (text.starts_with(beginning)) return true;
  return false;
}

void addText(std::string& row, const std::string& text) {
  row += '"';
  if (looksLikeFormula(text)) row += '\'';
  for (const char c : text) {
    if (c == '"') row += '"';
    row += c;
  }
  row += "\",";
}

std::string partsOf(const Topic& topic) {
  std::string text;
  for (const std::string& part : topic.parts) text.append(text.empty() ? "" : "; ").append(part);
  return text;
}

std::string threadOf(const Topic& topic) {
  std::string text;
  for (const TopicComment& comment : topic.comments)
    text.append(text.empty() ? "" : "\n")
        .append(utcText(comment.made) + ' ' + comment.author + ": " + comment.text);
  return text;
}

void addNumbers(std::string& row, const glm::dvec3* vector) {
  for (int i = 0; i < 3; ++i) {
    if (vector != nullptr) {
      std::array<char, 32> digits{};
      row.append(digits.data(), std::to_chars(digits.begin(), digits.end(), (*vector)[i]).ptr);
    }
    row += ',';
  }
}

}  // namespace

std::string topicCsv(const std::vector<Topic>& topics) {
  std::string table = kHeader;
  for (const Topic& topic : topics) {
    std::string row;
    for (const std::string& text :
         {topic.guid, std::string(kTopicTypes[static_cast<std::size_t>(topic.kind)]), topic.status,
          topic.title, topic.description, topic.author, utcText(topic.made), utcText(topic.changed),
          topic.assignee, partsOf(topic), std::to_string(topic.comments.size()), threadOf(topic)})
      addText(row, text);
    addNumbers(row, topic.places.empty() ? nullptr : topic.places.data());
    if (topic.view) {
      const glm::dvec3 direction = topic.view->worldFromCamera.orientation * glm::dvec3(0.0, 0.0, -1.0);
      addNumbers(row, &topic.view->worldFromCamera.position);
      addNumbers(row, &direction);
    } else {
      addNumbers(row, nullptr);
      addNumbers(row, nullptr);
    }
    row.back() = '\r';
    table += row + '\n';
  }
  return table;
}

}  // namespace tandem::client
