#include <imgui.h>

#include <algorithm>
#include <cctype>

#include "assets/base/assert.h"
#include "client/picture/colours.h"
#include "client/session/holding_words.h"
#include "client/viewer/panels.h"

namespace tandem::client {
namespace {

std::string lowered(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The text, or the beginning of it that fits into `width` with dots after it.
std::string shortened(const std::string& text, float width) {
  if (ImGui::CalcTextSize(text.c_str()).x <= width) return text;
  std::string kept = text;
  while (!kept.empty()) {
    // Whole characters only: the following bytes of UTF-8 look like 10xxxxxx.
    do kept.pop_back();
    while (!kept.empty() && (static_cast<unsigned char>(kept.back()) & 0xC0) == 0x80);
    if (!kept.empty() && (static_cast<unsigned char>(kept.back()) & 0xC0) == 0xC0) kept.pop_back();
    if (ImGui::CalcTextSize((kept + "...").c_str()).x <= width) break;
  }
  return kept + "...";
}

/// An eye, open or struck out; true when clicked.
bool eyeButton(const char* id, bool open, bool dim) {
  const float size = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const bool clicked = ImGui::InvisibleButton(id, ImVec2(size * 1.3f, size));
  const bool hot = ImGui::IsItemHovered();
  const ImVec2 centre(at.x + 0.65f * size, at.y + 0.5f * size);
  const ImU32 colour =
      theme::packed(hot ? theme::kAccent : theme::kMuted, open ? (dim ? 0.45f : 0.9f) : 0.45f);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const float w = 0.46f * size, h = 0.42f * size;
  list.AddBezierQuadratic({centre.x - w, centre.y}, {centre.x, centre.y - 1.6f * h}, {centre.x + w, centre.y},
                          colour, 1.3f);
  list.AddBezierQuadratic({centre.x - w, centre.y}, {centre.x, centre.y + 1.6f * h}, {centre.x + w, centre.y},
                          colour, 1.3f);
  if (open) {
    list.AddCircleFilled(centre, 0.17f * size, colour);
  } else {
    list.AddLine({centre.x - w, centre.y + h}, {centre.x + w, centre.y - h}, colour, 1.3f);
  }
  if (hot) ImGui::SetTooltip(open ? "Hide" : "Show");
  return clicked;
}

/// Open or closed triangle of a tree node; true when clicked.
bool foldButton(const char* id, bool open) {
  const float size = ImGui::GetTextLineHeight();
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const bool clicked = ImGui::InvisibleButton(id, ImVec2(size * 0.9f, size));
  const ImU32 colour = theme::packed(theme::kMuted);
  const ImVec2 c(at.x + 0.4f * size, at.y + 0.52f * size);
  const float r = 0.24f * size;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (open) {
    list.AddTriangleFilled({c.x - r, c.y - 0.6f * r}, {c.x + r, c.y - 0.6f * r}, {c.x, c.y + 0.8f * r},
                           colour);
  } else {
    list.AddTriangleFilled({c.x - 0.6f * r, c.y - r}, {c.x + 0.8f * r, c.y}, {c.x - 0.6f * r, c.y + r},
                           colour);
  }
  return clicked;
}

}  // namespace

void partMenu(const PanelContext& context, const std::vector<PartId>& parts) {
  PartDisplay& display = context.ui.parts;
  if (parts.empty()) return;
  const bool visible = display.visible(parts.front()), transparent = display.transparent(parts.front());
  if (ImGui::MenuItem("Fit", "F")) context.ui.fit = parts;
  if (ImGui::MenuItem(display.isolating() ? "Isolate / end isolation" : "Isolate", "I"))
    display.isolate(parts);
  if (ImGui::MenuItem(visible ? "Hide" : "Show", "H"))
    for (const PartId part : parts) display.setHidden(part, visible);
  if (ImGui::MenuItem("Transparent", "T", transparent))
    for (const PartId part : parts) display.setTransparent(part, !transparent);
  if (ImGui::MenuItem("Show all", "Shift+H")) display.showAll();
  if (parts.size() > 1 && parts.size() <= document::kMaxApart && ImGui::MenuItem("Explode")) {
    display.style.apart = parts;
    display.style.explode = 1.0;
  }
  if (context.model.wayOut.possible && parts.size() == 1 && context.model.scene->parts[parts[0]].movable &&
      ImGui::MenuItem("Find its way out"))
    context.actions.findWayOut = parts[0];
  if (context.model.role != sync::Role::instructor || parts.size() != 1) return;
  const SiteId owner = parts[0] < context.model.owner.size() ? context.model.owner[parts[0]] : kNoSite;
  ImGui::Separator();
  if (ImGui::MenuItem("Take away from its owner", nullptr, false, owner != kNoSite))
    context.actions.revoke = parts[0];
}

PartTree::PartTree(const assets::Scene& scene)
    : scene_(scene), children_(scene.tree.size()), partsOf_(scene.tree.size()), open_(scene.tree.size()) {
  for (std::uint32_t node = 0; node < scene.tree.size(); ++node) {
    const std::uint32_t parent = scene.tree[node].parent;
    if (parent < scene.tree.size()) {
      children_[parent].push_back(node);
    } else {
      roots_.push_back(node);
    }
  }
  for (std::size_t p = 0; p < scene.parts.size(); ++p) {
    const std::uint32_t node = scene.parts[p].treeNode;
    (node < partsOf_.size() ? partsOf_[node] : loose_).push_back(static_cast<PartId>(p));
  }
  // Opens the upper levels while their rows fit a screen.
  std::size_t shown = roots_.size();
  for (std::uint32_t node = 0; node < scene.tree.size(); ++node) {
    const bool parentOpen = scene.tree[node].parent >= scene.tree.size() || open_[scene.tree[node].parent];
    const std::size_t more = children_[node].size() + partsOf_[node].size();
    if (!parentOpen || shown + more > 60) continue;
    open_[node] = true;
    shown += more;
  }
}

std::vector<PartId> PartTree::partsUnder(std::uint32_t node) const {
  ASSERT(node < children_.size());
  std::vector<PartId> parts;
  std::vector<std::uint32_t> pending{node};
  while (!pending.empty()) {
    const std::uint32_t n = pending.back();
    pending.pop_back();
    parts.insert(parts.end(), partsOf_[n].begin(), partsOf_[n].end());
    pending.insert(pending.end(), children_[n].begin(), children_[n].end());
  }
  return parts;
}

void PartTree::collect(std::uint32_t node, int depth, std::vector<Row>& rows) const {
  const bool single = children_[node].empty() && partsOf_[node].size() == 1;
  if (single) {
    rows.push_back({node, partsOf_[node][0], depth, false});
    return;
  }
  if (partsUnder(node).empty()) return;
  rows.push_back({node, kNoPart, depth, true});
  if (!open_[node]) return;
  for (const PartId part : partsOf_[node]) rows.push_back({assets::kNone, part, depth + 1, false});
  for (const std::uint32_t child : children_[node]) collect(child, depth + 1, rows);
}

void PartTree::collectMatches(const std::string& needle, std::vector<Row>& rows) const {
  for (std::size_t p = 0; p < scene_.parts.size(); ++p)
    if (lowered(scene_.parts[p].name).find(needle) != std::string::npos)
      rows.push_back({assets::kNone, static_cast<PartId>(p), 0, false});
}

std::string PartTree::nameOf(const Row& row) const {
  const std::string& name = row.part != kNoPart ? scene_.parts[row.part].name : scene_.tree[row.node].name;
  if (!name.empty()) return name;
  return row.part != kNoPart ? "Part without a name"
                             : "Group of " + std::to_string(partsUnder(row.node).size());
}

void PartTree::drawMenu(const PanelContext& context, const Row& row) {
  if (!ImGui::BeginPopupContextItem("menu")) return;
  ImGui::TextDisabled("%s", nameOf(row).c_str());
  ImGui::Separator();
  partMenu(context, row.part != kNoPart ? std::vector<PartId>{row.part} : partsUnder(row.node));
  ImGui::EndPopup();
}

void PartTree::drawRow(const PanelContext& context, const Row& row) {
  PartDisplay& display = context.ui.parts;
  ImGui::PushID(static_cast<int>(row.part != kNoPart ? row.part : kMaxParts + 1 + row.node));
  const auto parts = row.part != kNoPart ? std::vector<PartId>{row.part} : partsUnder(row.node);
  const bool visible = std::any_of(parts.begin(), parts.end(), [&](PartId p) { return display.visible(p); });
  if (eyeButton("eye", visible, row.part != kNoPart && display.transparent(row.part)))
    for (const PartId part : parts) display.setHidden(part, visible);
  ImGui::SameLine(0.0f, 2.0f);
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + static_cast<float>(row.depth) * 14.0f * context.scale);
  if (row.hasChildren) {
    if (foldButton("fold", open_[row.node])) open_[row.node] = !open_[row.node];
  } else {
    ImGui::Dummy(ImVec2(ImGui::GetTextLineHeight() * 0.9f, 0.0f));
  }
  ImGui::SameLine(0.0f, 2.0f);
  const SiteId owner =
      row.part != kNoPart && row.part < context.model.owner.size() ? context.model.owner[row.part] : kNoSite;
  const SiteView* site = owner != kNoSite ? findSite(context.model, owner) : nullptr;
  const std::string holders = row.part != kNoPart ? holdersInWords(context.model, row.part) : std::string();
  if (!visible) ImGui::PushStyleColor(ImGuiCol_Text, theme::kMuted);
  const bool selected = row.part != kNoPart && row.part == display.selected;
  const std::string name = nameOf(row);
  const float ownerWidth = site ? ImGui::CalcTextSize(holders.c_str()).x + 24.0f * context.scale : 0.0f;
  const std::string shown = shortened(name, ImGui::GetContentRegionAvail().x - ownerWidth) + "###name";
  if (ImGui::Selectable(shown.c_str(), selected, ImGuiSelectableFlags_AllowItemOverlap)) {
    if (row.part != kNoPart) {
      display.selected = selected ? kNoPart : row.part;
    } else {
      open_[row.node] = !open_[row.node];
    }
  }
  if (ImGui::IsItemHovered()) {
    if (row.part != kNoPart) display.hovered = row.part;
    if (ImGui::IsMouseDoubleClicked(0)) context.ui.fit = parts;
    if (shown.size() != name.size() + 7) ImGui::SetTooltip("%s", name.c_str());
  }
  if (!visible) ImGui::PopStyleColor();
  drawMenu(context, row);
  if (site) {
    ImGui::SameLine(std::max(ImGui::GetContentRegionMax().x - ownerWidth + 6.0f * context.scale, 60.0f));
    colourDot(srgb(site->info.colour));
    ImGui::SameLine(0.0f, 4.0f);
    ImGui::TextColored(theme::kMuted, "%s", holders.c_str());
  }
  ImGui::PopID();
}

void PartTree::draw(const PanelContext& context) {
  ImGui::SetNextItemWidth(-1.0f);
  ImGui::InputTextWithHint("##search", "Search parts", context.ui.search.data(), context.ui.search.size());
  if (ImGui::Button("Fit all")) context.ui.fit = std::vector<PartId>{};
  ImGui::SameLine();
  if (ImGui::Button("Show all")) context.ui.parts.showAll();
  if (context.model.role == sync::Role::instructor && !context.model.replay) {
    ImGui::SameLine();
    if (ImGui::Button("Reset")) context.actions.resetParts = true;
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Put every part that nobody holds back to its first place");
  }
  ImGui::Spacing();
  std::vector<Row> rows;
  const std::string needle = lowered(context.ui.search.data());
  if (needle.empty()) {
    for (const std::uint32_t root : roots_) collect(root, 0, rows);
    for (const PartId part : loose_) rows.push_back({assets::kNone, part, 0, false});
  } else {
    collectMatches(needle, rows);
  }
  ImGui::BeginChild("rows");
  ImGuiListClipper clipper;
  clipper.Begin(static_cast<int>(rows.size()));
  while (clipper.Step())
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i)
      drawRow(context, rows[static_cast<std::size_t>(i)]);
  if (rows.empty()) ImGui::TextDisabled("No part has this in its name");
  ImGui::EndChild();
}

}  // namespace tandem::client
