#include "assets/cad_import/step_document.h"

#include <algorithm>

#include <IFSelect_ReturnStatus.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Message_ProgressIndicator.hxx>
#include <STEPCAFControl_ExternFile.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <TColStd_SequenceOfAsciiString.hxx>
#include <TCollection_HAsciiString.hxx>
#include <XCAFDoc_DocumentTool.hxx>

namespace tandem::cad_import {
namespace {

constexpr double kReadShare = 0.25, kTransferShare = 0.6;  // of the whole import's time, roughly

/// Passes the progress of the transfer on.
class TransferProgress : public Message_ProgressIndicator {
 public:
  explicit TransferProgress(const ImportOptions& options) : options_(options) {}

 protected:
  void Show(const Message_ProgressScope&, const Standard_Boolean) override {
    options_.progress(kReadShare + kTransferShare * GetPosition(), "shapes");
  }

 private:
  const ImportOptions& options_;
};

}  // namespace

Result<StepDocument> readStep(const std::string& path, const ImportOptions& options) {
  Message::DefaultMessenger()->ChangePrinters().Clear();
  STEPCAFControl_Reader reader;
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  reader.SetColorMode(true);
  reader.SetNameMode(true);
  reader.SetMatMode(true);
  reader.SetGDTMode(true);
  reader.SetLayerMode(false);
  reader.SetViewMode(false);
  options.progress(0.0, "the file");
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) return Error{"not a STEP file that can be read"};
  StepDocument read;
  TColStd_SequenceOfAsciiString lengths, angles, solidAngles;
  reader.ChangeReader().FileUnits(lengths, angles, solidAngles);
  for (int i = 1; i <= lengths.Length(); ++i) read.lengthUnits.emplace_back(lengths.Value(i).ToCString());
  read.document = new TDocStd_Document("BinXCAF");
  XCAFDoc_DocumentTool::Set(read.document->Main(), false);
  options.progress(kReadShare, "shapes");
  const Handle(TransferProgress) progress = new TransferProgress(options);
  if (!reader.Transfer(read.document, progress->Start())) return Error{"no shape in it can be used"};
  for (NCollection_DataMap<TCollection_AsciiString, Handle(STEPCAFControl_ExternFile)>::Iterator at(
           reader.ExternFiles());
       at.More(); at.Next())
    if (at.Value().IsNull() || at.Value()->GetLoadStatus() != IFSelect_RetDone)
      read.missingFiles.emplace_back(at.Key().ToCString());
  std::sort(read.missingFiles.begin(), read.missingFiles.end());
  return read;
}

}  // namespace tandem::cad_import
