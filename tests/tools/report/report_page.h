// What tests of the report's pages look at them with.
#pragma once

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <cctype>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"
#include "tools/report/report_json.h"

namespace orient {

// What makes the text no well-formed XML as far as elements go; empty where it is.
inline std::string Malformed(const std::string& html) {
  std::vector<std::string> open;
  for (size_t i = html.find('<'); i != std::string::npos; i = html.find('<', i + 1)) {
    if (html.compare(i, 2, "<!") == 0) continue;  // the document type
    const size_t end = html.find_first_of("<>", i + 1);
    if (end == std::string::npos || html[end] == '<')
      return "a < that opens nothing: " + html.substr(i, 60);
    const bool closing = html[i + 1] == '/';
    const size_t first = i + (closing ? 2 : 1);
    const std::string name = html.substr(first, html.find_first_of(" />\n", first) - first);
    if (name.empty() || std::isalpha(static_cast<unsigned char>(name[0])) == 0)
      return "no element: " + html.substr(i, 60);
    if (closing) {
      if (open.empty() || open.back() != name) return "unexpected </" + name + ">";
      open.pop_back();
    } else if (html[end - 1] != '/') {
      open.push_back(name);
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> is never closed";
}

// report.json of what lies in this folder.
inline nlohmann::json ReportJsonOf(const std::string& directory) {
  const BlockRecord block = ReadBlockRecord(directory);
  return nlohmann::json::parse(ReadFile(WriteReportJson(block, Judge(block))));
}

inline bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

inline void WritePng(const std::string& path, int width, int height, bool noise) {
  GDALAllRegister();
  const GDALDatasetUniquePtr memory(GetGDALDriverManager()->GetDriverByName("MEM")->Create(
      "", width, height, 3, GDT_Byte, nullptr));
  std::vector<unsigned char> row(static_cast<size_t>(width));
  unsigned state = TestSeed();
  for (int y = 0; y < height; ++y)
    for (int band = 1; band <= 3; ++band) {
      for (unsigned char& value : row)
        value = noise ? static_cast<unsigned char>((state = state * 1664525u + 1013904223u) >> 24)
                      : static_cast<unsigned char>(y);
      ASSERT_EQ(memory->GetRasterBand(band)->RasterIO(GF_Write, 0, y, width, 1, row.data(), width,
                                                      1, GDT_Byte, 0, 0),
                CE_None);
    }
  const GDALDatasetUniquePtr png(GetGDALDriverManager()->GetDriverByName("PNG")->CreateCopy(
      path.c_str(), memory.get(), FALSE, nullptr, nullptr, nullptr));
  ASSERT_TRUE(png);
}

}  // namespace orient
