#pragma once

// Dimensions and tolerances that a STEP file states (PMI), as words beside the part that they belong to.

#include <map>
#include <string>
#include <vector>

#include <TDF_Label.hxx>
#include <TDocStd_Document.hxx>

namespace tandem::cad_import {

class StepTolerances {
 public:
  explicit StepTolerances(const Handle(TDocStd_Document) & document);

  /// Of one product: "diameter 12 mm +0.018 -0", "flatness 0.05 mm"; in the file's order.
  std::vector<std::string> of(const TDF_Label& product) const;

 private:
  std::map<std::string, std::vector<std::string>> byProduct_;  // by the label's entry
};

}  // namespace tandem::cad_import
