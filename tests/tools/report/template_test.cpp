#include "tools/report/template.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace orient {
namespace {

std::string Filled(std::string_view text, const std::vector<Filling>& fillings) {
  return FillText("test", text, fillings).Text();
}

// What FillText says; empty where it goes through.
std::string Complaint(std::string_view text, const std::vector<Filling>& fillings) {
  try {
    FillText("page.html#row", text, fillings);
    return "";
  } catch (const std::logic_error& error) {
    return error.what();
  }
}

TEST(Template, PlacesTakeWhatHasTheirName) {
  EXPECT_EQ(Filled("<p>{{a}} of {{b}}, {{a}}</p>", {{"a", 3}, {"b", "four"}}),
            "<p>3 of four, 3</p>");
  EXPECT_EQ(Filled("no place", {}), "no place");
}

TEST(Template, TextIsEscapedAndMarkupIsNot) {
  EXPECT_EQ(Filled("{{a}}", {{"a", "<b> & \"c\""}}), "&lt;b&gt; &amp; &quot;c&quot;");
  EXPECT_EQ(Filled("{{{a}}}", {{"a", Markup("<b>&amp;</b>")}}), "<b>&amp;</b>");
}

TEST(Template, BracesInWhatIsFilledInStay) {
  EXPECT_EQ(Filled("{{a}}{{b}}", {{"a", "{{b}}"}, {"b", "{{{c}}}"}}), "{{b}}{{{c}}}");
}

TEST(Template, ComplaintsNameTemplateAndPlace) {
  EXPECT_EQ(Complaint("{{width}}", {}),
            "template page.html#row: nothing is given for the place \"width\"");
  EXPECT_EQ(Complaint("", {{"width", 1}}), "template page.html#row: there is no place \"width\"");
  EXPECT_EQ(Complaint("a {{width} b", {{"width", 1}}),
            "template page.html#row: the place \"{{width} b\" has no end");
}

TEST(Template, TextCannotPassForMarkupNorMarkupForText) {
  EXPECT_EQ(Complaint("{{{name}}}", {{"name", "<script>"}}),
            "template page.html#row: the place \"name\" takes markup, not text");
  EXPECT_EQ(Complaint("{{name}}", {{"name", Markup("<b/>")}}),
            "template page.html#row: the place \"name\" takes text, not markup");
}

TEST(Template, MarkupGrowsByLines) {
  Markup list;
  list += Markup("<li>1</li>");
  list += Markup();
  list += Markup("<li>2</li>");
  EXPECT_EQ(list.Text(), "<li>1</li>\n<li>2</li>");
}

TEST(Template, FileEndsWhereItsFirstPartBegins) {
  EXPECT_EQ(Fill("map.html#empty").Text(),
            "<p class=\"note\">No photo has a position on the ground yet.</p>");
  const std::string photo = Fill("photo.html", {{"number", 7},
                                                {"all", "#photos"},
                                                {"photo", "a<b"},
                                                {"status", "ok"},
                                                {"thumbnail", Markup()},
                                                {"messages", Markup()},
                                                {"exterior", Markup("<p>there</p>")},
                                                {"interior", Markup()}})
                                .Text();
  EXPECT_TRUE(photo.starts_with("<section class=\"photo\" id=\"photo-7\">\n<h2>a&lt;b "));
  EXPECT_TRUE(photo.ends_with("</section>"));
  EXPECT_EQ(photo.find("<!--"), std::string::npos);
}

TEST(Template, AbsentFileOrPartIsALogicError) {
  EXPECT_THROW(Fill("absent.html"), std::logic_error);
  EXPECT_THROW(Fill("map.html#absent"), std::logic_error);
  EXPECT_THROW(ReportFile("absent.css"), std::logic_error);
}

// A line that begins a part but for a letter would leave the part in the one before it.
TEST(Template, EveryCommentOfATemplateBeginsAPart) {
  size_t pages = 0;
  for (const EmbeddedFile& file : ReportFiles()) {
    if (!file.name.ends_with(".html")) continue;
    ++pages;
    for (size_t at = 0; (at = file.contents.find("<!--", at)) != std::string_view::npos; ++at) {
      const std::string_view line = file.contents.substr(at, file.contents.find('\n', at) - at);
      EXPECT_TRUE(line.starts_with("<!-- part: ") && line.ends_with(" -->"))
          << file.name << ": " << line;
    }
  }
  EXPECT_GT(pages, 0u);
}

}  // namespace
}  // namespace orient
