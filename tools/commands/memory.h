// How the program deals with memory and open files.
#pragma once

namespace orient {

// Released memory stays with the program instead of going back to the system block by block. Every
// window and every drawing is some hundred kilobytes, made and dropped again: glibc would map each
// one anew, and the system fill it with zeros, a fifth of the time that a scan takes. For `main`
// alone, as it holds for the whole program.
void KeepReleasedMemory();

// As many files may be open as the system lets the program ask for: the usual soft limit of 1024 is
// too low for many threads, each with the scans around a photo. For `main` alone.
void AllowManyFiles();

// GDAL keeps decoded pixels in a twentieth of the machine's memory: at most half a gigabyte, unless
// the environment says otherwise (GDAL_CACHEMAX). For `main` alone, too.
void BoundBlockCache(int megabytes = 512);

}  // namespace orient
