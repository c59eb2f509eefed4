#include "client/session/document_words.h"

#include <algorithm>
#include <iterator>

namespace tandem::client {

using namespace document;

namespace {

constexpr std::size_t kLongest = 40;  // bytes of a quoted text

struct TextOf {
  std::string operator()(const Removed&) const { return {}; }
  std::string operator()(const Note& note) const { return note.text; }
  std::string operator()(const Comment& comment) const { return comment.text; }
  std::string operator()(const ClashVerdict& verdict) const { return verdict.text; }
  std::string operator()(const auto& named) const { return named.name; }
};

}  // namespace

std::string shortened(const std::string& text, std::size_t most) {
  std::string cut = text.substr(0, most);
  if (cut.size() < text.size()) {
    while (!cut.empty() && (static_cast<unsigned char>(text[cut.size()]) & 0xC0u) == 0x80u) cut.pop_back();
    cut += "...";
  }
  std::replace(cut.begin(), cut.end(), '\n', ' ');
  return cut;
}

std::string ownName(const ViewModel& model) {
  const SiteView* self = selfSite(model);
  return self == nullptr ? std::string() : self->info.name;
}

std::string inWords(const Body& body) {
  const std::string kind = std::holds_alternative<Comment>(body) ? "reply" : kKindNames[body.index()];
  const std::string text = std::visit(TextOf{}, body);
  return text.empty() ? kind : kind + " \"" + shortened(text, kLongest) + '"';
}

std::string inWords(const Document& document) {
  if (document.size() == 0) return "empty";
  std::string words = std::to_string(document.size()) + (document.size() == 1 ? " entry" : " entries");
  const auto& byRevision = document.byRevision();
  const auto last = std::find_if(byRevision.rbegin(), byRevision.rend(),
                                 [&](const auto& each) { return !document.find(each.second)->removed(); });
  const Entry& entry = *document.find(last->second);
  const std::string author = entry.authorName.empty() ? "" : " by " + entry.authorName;
  return words + ", the last" + author + ": " + inWords(entry.body);
}

}  // namespace tandem::client
