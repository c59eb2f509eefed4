#include "client/exchange/topic_page.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <string_view>

#include "client/exchange/utc_time.h"

namespace tandem::client {
namespace {

constexpr const char* kStyle = R"(
body { font: 15px/1.45 sans-serif; color: #21262e; background: #f6f7f9; margin: 0 auto; max-width: 62rem;
  padding: 1.5rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.1rem; margin: 0 0 .3rem; }
article { background: #fff; border: 1px solid #d6dbe0; border-radius: 6px; padding: 1rem; margin: 0 0 1rem;
  display: flow-root; }
img { float: right; width: 46%; margin: 0 0 .6rem 1rem; border-radius: 4px; }
.facts { color: #6b7582; font-size: .85rem; margin: 0 0 .6rem; }
.status { border: 1px solid #2a6bd1; border-radius: 9px; color: #2a6bd1; padding: 0 .5rem; }
.camera { color: #6b7582; font: .75rem monospace; clear: both; margin: .6rem 0 0; }
ol { list-style: none; padding: 0 0 0 .8rem; border-left: 3px solid #d6dbe0; } li { margin: 0 0 .4rem; }
p { margin: 0 0 .5rem; overflow-wrap: anywhere; }
@media print { body { background: #fff; } article { break-inside: avoid; } }
)";

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      case '\'':
        html += "&#39;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) { return k < bytes.size() ? std::uint32_t{bytes[k]} : 0u; };
    const std::uint32_t bits = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    text += kDigits[bits >> 18];
    text += kDigits[bits >> 12 & 63];
    text += i + 1 < bytes.size() ? kDigits[bits >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? kDigits[bits & 63] : '=';
  }
  return text;
}

std::string numbers(const glm::dvec3& v) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "%.4g %.4g %.4g", v.x, v.y, v.z);
  return text.data();
}

std::string who(const std::string& author, std::int64_t made) {
  std::string time = utcText(made);
  time[10] = ' ';
  return escaped(author) + ", <time datetime=\"" + utcText(made) + "\">" + time.substr(0, 16) + " UTC</time>";
}

std::string article(const Topic& topic) {
  std::string html = "<article id=\"" + escaped(topic.guid) + "\">\n";
  if (!topic.picture.empty())
    html +=
        "<img alt=\"The view of this topic\" src=\"data:image/png;base64," + base64(topic.picture) + "\">\n";
  html += "<h2>" + escaped(topic.title) + "</h2>\n<p class=\"facts\"><span class=\"status\">" +
          escaped(topic.status) + "</span> " + kTopicTypes[static_cast<std::size_t>(topic.kind)] + " of " +
          who(topic.author, topic.made);
  if (topic.changed != topic.made) html += ", changed " + utcText(topic.changed).substr(0, 10);
  if (!topic.assignee.empty()) html += "; assigned to " + escaped(topic.assignee);
  html += "</p>\n";
  if (!topic.description.empty() && topic.description != topic.title)
    html += "<p>" + escaped(topic.description) + "</p>\n";
  for (std::size_t i = 0; i < topic.parts.size(); ++i)
    html += (i == 0 ? "<p class=\"facts\">Parts: " : ", ") + escaped(topic.parts[i]);
  if (!topic.parts.empty()) html += "</p>\n";
  if (!topic.comments.empty()) html += "<ol>\n";
  for (const TopicComment& comment : topic.comments)
    html += "<li>" + escaped(comment.text) + " <span class=\"facts\">" + who(comment.author, comment.made) +
            "</span></li>\n";
  if (!topic.comments.empty()) html += "</ol>\n";
  if (topic.view) {
    const Pose& camera = topic.view->worldFromCamera;
    html += "<p class=\"camera\">camera " + numbers(camera.position) + " m, towards " +
            numbers(camera.orientation * glm::dvec3(0.0, 0.0, -1.0)) + "</p>\n";
  }
  return html + "</article>\n";
}

}  // namespace

std::string topicPage(const std::string& title, const std::vector<Topic>& topics) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
      "http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'\">\n<meta name=\"viewport\" content=\"width=device-width\">\n<title>" +
      escaped(title) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" + escaped(title) +
      "</h1>\n<p class=\"facts\">" + std::to_string(topics.size()) +
      (topics.size() == 1 ? " topic" : " topics") + "</p>\n";
  for (const Topic& topic : topics) html += article(topic);
  return html + "</body>\n</html>\n";
}

}  // namespace tandem::client
