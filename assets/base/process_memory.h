#pragma once

// What a program keeps of the memory that it has freed.

namespace tandem {

/// From now on arrays of a quarter of a megabyte and more go back to the system when they are freed. Of
/// itself glibc keeps ever larger ones for later, and a program that has read a large scene never gets
/// smaller again. To be called once, before the scene is read.
void returnFreedArrays();

/// Gives back what is free now of smaller pieces.
void returnFreedPieces();

}  // namespace tandem
