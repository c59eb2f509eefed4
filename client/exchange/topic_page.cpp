#include "client/exchange/topic_page.h"

#include <sodium.h>

#include <array>
#include <cstdint>
#include <cstdio>

#include "assets/base/utc_time.h"
#include "client/plot/svg_plot.h"

namespace tandem::client {
namespace {

using report::escaped;

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

std::string base64(const std::vector<std::uint8_t>& bytes) {
  std::string text(sodium_base64_encoded_len(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), bytes.data(), bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();  // the terminating zero
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
