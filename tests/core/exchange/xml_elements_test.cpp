#include "core/exchange/xml_elements.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

XmlElement Read(const std::string& text) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a.xml", text);
  return ReadXml(folder / "a.xml");
}

std::string Complaint(const std::string& text) {
  try {
    Read(text);
  } catch (const InputError& error) {
    const std::string what = error.what();
    return what.substr(what.find("a.xml"));
  }
  return "";
}

TEST(XmlElements, ElementsKnowTheirLinesAttributesAndText) {
  const XmlElement root = Read(
      "\xEF\xBB\xBF<?xml version=\"1.0\"?>\r\n<!-- <no> -->\r\n<a one='1'>\r\n  first <b/>\r\n"
      "<c>\n<b two=\"&lt;2&gt;\"> 3 4 </b></c> last\n</a>\n");
  EXPECT_EQ(root.name, "a");
  EXPECT_EQ(root.line, 3);
  EXPECT_EQ(root.Attribute("one"), "1");
  EXPECT_TRUE(root.text.starts_with("first")) << root.text;
  EXPECT_TRUE(root.text.ends_with("last")) << root.text;
  EXPECT_EQ(root.At("b").line, 4);
  const XmlElement& b = root.At("c").At("b");
  EXPECT_EQ(b.line, 6);
  EXPECT_EQ(b.Attribute("two"), "<2>");
  EXPECT_EQ(b.Numbers(2), (std::vector<double>{3, 4}));
  EXPECT_EQ(root.Below("c"), root.Find("c"));
  EXPECT_EQ(root.All("b").size(), 1u);
}

TEST(XmlElements, WhatIsEscapedIsReadBack) {
  const std::string text = R"(<a> & "b" 'c')";
  EXPECT_EQ(Read("<r k=\"" + XmlEscaped(text) + "\">" + XmlEscaped(text) + "</r>").text, text);
  EXPECT_EQ(Read("<r k=\"" + XmlEscaped(text) + "\"/>").Attribute("k"), text);
}

TEST(XmlElements, BrokenFilesAreNamedByLineAndTag) {
  EXPECT_EQ(Complaint(""), "a.xml, line 1: this is no XML: it holds no element");
  EXPECT_EQ(Complaint("\nwords\n"), "a.xml, line 3: this is no XML: it holds no element");
  EXPECT_EQ(Complaint("<a>\n<b></b>\n"), "a.xml, line 2: the element a never ends");
  EXPECT_EQ(Complaint("<a>\n<b>\n</a>\n"),
            "a.xml, line 3: this is no XML: Start-end tags mismatch at \"</a>\"");
  EXPECT_EQ(Complaint("<a>\n<b c=d/></a>\n"),
            "a.xml, line 2: this is no XML: Error parsing element attribute at \"<b c=d/>\"");
  EXPECT_NE(Complaint("<a>\n<b c"), "");
  EXPECT_NE(Complaint("<a>\n<!-- "), "");
}

TEST(XmlElements, WhatADocumentTypeDeclaresMeansNothing) {
  const XmlElement root = Read(
      "<!DOCTYPE a [<!ENTITY b \"big\"><!ENTITY c SYSTEM \"file:///etc/passwd\">]>\n"
      "<a>&b;&c;</a>");
  EXPECT_EQ(root.text, "&b;&c;");
  EXPECT_EQ(root.line, 2);
}

TEST(XmlElements, TooDeepAFileIsRefused) {
  std::string text;
  for (int i = 0; i < 1000000; ++i) text += "<a>";
  for (int i = 0; i < 1000000; ++i) text += "</a>";
  EXPECT_EQ(Complaint(text), "a.xml, line 1: the elements are nested too deep");
}

}  // namespace
}  // namespace orient
