#include "assets/base/process_memory.h"

#include <malloc.h>

namespace tandem {

void returnFreedArrays() { ::mallopt(M_MMAP_THRESHOLD, 1 << 18); }

void returnFreedPieces() { ::malloc_trim(0); }

}  // namespace tandem
