#include <algorithm>
#include <iterator>

#include "assets/base/assert.h"
#include "client/simulation/scenario_fields.h"

namespace tandem::client {

namespace {

using Kind = Fault::Kind;

constexpr double kLongest = 1e5;  // s

/// How a kind of fault stands in a scenario: {"at": .., KEY: SITE or WORD, AMOUNT: .., "for_s": ..}.
struct Form {
  Kind kind;
  const char* key;
  const char* word;             // the value of the key; null: the name of a site
  const char* amount;           // null: none
  double perUnit, least, most;  // of the amount: SI for one of the scenario's units, and its range in those
  bool lasts;                   // takes "for_s"
};

constexpr Form kForms[] = {
    {Kind::leave, "leave", nullptr, nullptr, 1, 0, 0, false},
    {Kind::reset, "reset", nullptr, nullptr, 1, 0, 0, false},
    {Kind::diskFails, "disk", "fails", nullptr, 1, 0, 0, true},
    {Kind::diskSlow, "disk", "slow", "ms", 1e-3, 0, 1e5, true},
    {Kind::diskTears, "disk", "tears", nullptr, 1, 0, 0, true},
    {Kind::diskRots, "disk", "rots", nullptr, 1, 0, 0, false},
    {Kind::diskLies, "disk", "lies", nullptr, 1, 0, 0, true},
    {Kind::drift, "drift", nullptr, "ppm", 1, -9e5, 1e7, true},
    {Kind::wallStep, "wall_clock", "step", "s", 1, -1e9, 1e9, false},
    {Kind::cutUp, "cut", nullptr, nullptr, 1, 0, 0, true},
    {Kind::cutDown, "cut", nullptr, nullptr, 1, 0, 0, true},
    {Kind::delay, "delay", nullptr, "ms", 1e-3, 0, 1e5, true},
    {Kind::burst, "burst", nullptr, "loss", 1, 0, 1, true},
    {Kind::uplink, "uplink", nullptr, "bytes_per_s", 1, 1, 1e12, true},
    {Kind::malformed, "stranger", "malformed", nullptr, 1, 0, 0, true},
    {Kind::replay, "stranger", "replay", nullptr, 1, 0, 0, true},
    {Kind::escalate, "stranger", "escalate", nullptr, 1, 0, 0, true},
    {Kind::flood, "stranger", "flood", nullptr, 1, 0, 0, true},
    {Kind::forge, "stranger", "forge", nullptr, 1, 0, 0, true},
};

const char* wayOf(Kind kind) { return kind == Kind::cutUp ? "up" : "down"; }

/// Whether this form is the one of the entry, whose key has this value.
bool fits(const Form& form, const std::string& value, Fields& fields) {
  if (form.word != nullptr) return value == form.word;
  if (form.kind != Kind::cutUp && form.kind != Kind::cutDown) return true;
  return fields.requiredText("way") == wayOf(form.kind);
}

Fault parseForm(const Form& form, Fields& fields) {
  Fault fault;
  fault.kind = form.kind;
  if (form.word == nullptr) fault.site = fields.text(form.key, "");
  if (form.amount != nullptr)
    fault.amount = fields.required(form.amount, form.least, form.most) * form.perUnit;
  if (form.lasts) fault.lasts = fields.number("for_s", -1.0, 0.0, kLongest);
  return fault;
}

Fault parseKillOrPause(Fields& fields) {
  Fault fault;
  if (fields.has("pause")) {
    fault.site = fields.requiredText("pause");
    fault.kind = fault.site == "server" ? Kind::pauseServer : Kind::pauseSite;
    fault.lasts = fields.required("for_s", 0.0, kLongest);
  } else {
    fault.site = fields.requiredText("kill");
    fault.kind = fault.site == "server" ? Kind::killServer : Kind::killSite;
    fault.lasts = fields.number("restart_after_s", -1.0, 0.0, kLongest);
  }
  return fault;
}

Fault parseRevoke(Fields& fields) {
  Fault fault;
  fault.kind = Kind::revoke;
  fault.part = fields.requiredText("revoke");
  fault.site = fields.requiredText("by");
  return fault;
}

Fault parseOne(Fields& fields) {
  if (fields.has("kill") != fields.has("pause")) return parseKillOrPause(fields);
  if (fields.has("revoke")) return parseRevoke(fields);
  for (const Form& form : kForms)
    if (fields.has(form.key) && fits(form, fields.requiredText(form.key), fields))
      return parseForm(form, fields);
  throw fields.where() +
      ": needs one of \"kill\", \"pause\", \"leave\", \"revoke\", \"reset\", \"disk\", "
      "\"drift\", \"wall_clock\", \"cut\", \"delay\", \"burst\", \"uplink\", "
      "\"stranger\", with a value that it knows";
}

}  // namespace

Fault parseFault(const Json& entry, const std::string& where) {
  Fields fields(entry, where);
  const double at = fields.required("at", 0.0, kLongest);
  Fault fault = parseOne(fields);
  fault.at = at;
  fields.refuseUnknown();
  return fault;
}

Json faultJson(const Fault& fault) {
  Json entry = Json::object();
  entry["at"] = fault.at;
  const bool kills = fault.kind == Kind::killServer || fault.kind == Kind::killSite;
  if (kills || fault.kind == Kind::pauseServer || fault.kind == Kind::pauseSite) {
    entry[kills ? "kill" : "pause"] = fault.site.empty() ? "server" : fault.site;
    if (fault.lasts >= 0.0) entry[kills ? "restart_after_s" : "for_s"] = fault.lasts;
    return entry;
  }
  if (fault.kind == Kind::revoke) {
    entry["revoke"] = fault.part;
    entry["by"] = fault.site;
    return entry;
  }
  const auto form = std::find_if(std::begin(kForms), std::end(kForms),
                                 [&](const Form& each) { return each.kind == fault.kind; });
  ASSERT(form != std::end(kForms));
  entry[form->key] = form->word != nullptr ? form->word : fault.site.c_str();
  if (fault.kind == Kind::cutUp || fault.kind == Kind::cutDown) entry["way"] = wayOf(fault.kind);
  if (form->amount != nullptr) entry[form->amount] = fault.amount / form->perUnit;
  if (form->lasts && fault.lasts >= 0.0) entry["for_s"] = fault.lasts;
  return entry;
}

}  // namespace tandem::client
