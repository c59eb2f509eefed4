#include "tests/support/source_file.h"

namespace tandem {

std::string sourceFile(std::string_view path) { return std::string(TANDEM_SOURCE_DIR "/").append(path); }

}  // namespace tandem
