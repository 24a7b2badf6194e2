#include "baton/bridge/sexpr.hpp"

#include <gmock/gmock.h>

#include <string>

#include "tests/support/random.hpp"

namespace baton::bridge {
namespace {

using testing::HasSubstr;

/// The text of an expression, one space between elements.
std::string text_of_sexpr(const SExpr& expression) {
  if (!expression.atom.empty()) return std::string(expression.atom);
  std::string text = "(";
  for (const SExpr& element : expression.list)
    text += (text.size() > 1 ? " " : "") + text_of_sexpr(element);
  return text + ")";
}

std::string any_sexpr(test::Random& random, int depth) {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzQ0123456789_.-+'\"";
  if (depth == 0 || random.below(3) > 0) {
    std::string atom;
    for (std::size_t i = 0; i <= random.below(8); ++i)
      atom += kLetters[random.below(kLetters.size())];
    return atom;
  }
  std::string list = "(";
  const std::size_t elements = random.below(5);
  for (std::size_t i = 0; i < elements; ++i)
    list += (list.size() > 1 ? " " : "") + any_sexpr(random, depth - 1);
  return list + ")";
}

/// Why a text is refused; "": it is not.
std::string refused(const std::string& text) {
  try {
    static_cast<void>(parse_sexprs(text));
  } catch (const SExprError& error) {
    return error.what();
  }
  return "";
}

TEST(SExprTest, ReadsWhatWasWritten) {
  for (int seed = 0; seed < 5000; ++seed) {
    test::Random random(static_cast<std::uint64_t>(seed));
    const std::string text = "(" + any_sexpr(random, 6) + " " + any_sexpr(random, 6) + ")";
    const std::vector<SExpr> read = parse_sexprs(text);
    ASSERT_EQ(read.size(), 1U) << text;
    EXPECT_EQ(text_of_sexpr(read.front()), text);
  }
}

TEST(SExprTest, SpacesDoNotMatter) {
  for (int seed = 0; seed < 2000; ++seed) {
    test::Random random(static_cast<std::uint64_t>(seed));
    const std::string text = "(x " + any_sexpr(random, 5) + ")";
    std::string spaced;
    for (const char c : text) {
      constexpr std::string_view kSpaces = " \t\r\n";
      if (c == '(' || c == ')' || c == ' ') spaced += std::string(random.below(3), kSpaces[random.below(4)]);
      spaced += c;
      if (c == '(' || c == ')') spaced += std::string(random.below(3), kSpaces[random.below(4)]);
    }
    EXPECT_EQ(text_of_sexpr(parse_sexprs(spaced).at(0)), text);
  }
}

TEST(SExprTest, BrokenTextIsReadOrRefusedWithALine) {
  int refusals = 0;
  for (int seed = 0; seed < 5000; ++seed) {
    test::Random random(static_cast<std::uint64_t>(seed));
    std::string text = "(" + any_sexpr(random, 6) + ")";
    for (std::size_t i = 0; i <= random.below(3); ++i)
      text[random.below(text.size())] = static_cast<char>(random.integer(-128, 127));
    if (random.coin()) text.resize(random.below(text.size()) + 1);
    const std::string why = refused(text);
    refusals += why.empty() ? 0 : 1;
    EXPECT_EQ(why.find('\n'), std::string::npos);
  }
  EXPECT_GT(refusals, 1000);
}

TEST(SExprTest, BracketsHaveToMatch) {
  EXPECT_THAT(refused("(a (b)"), HasSubstr("not closed"));
  EXPECT_THAT(refused("(a))"), HasSubstr("not open"));
  EXPECT_THAT(refused(std::string(100'000, '(')), HasSubstr("more than 32 deep"));
  EXPECT_EQ(refused(""), "");
  EXPECT_EQ(refused(std::string(32, '(') + std::string(32, ')')), "");
}

TEST(SExprTest, FindsNumbersByTheHeadsOfTheirLists) {
  const SExpr all{{}, parse_sexprs("(time (now 12.34))(HJ (n q_lj1)(ax -0.5))")};
  EXPECT_EQ(all.find("time").find("now").at(1).number(), 12.34);
  EXPECT_EQ(all.find("HJ").find("n").at(1).atom, "q_lj1");
  EXPECT_EQ(all.find("HJ").find("ax").at(1).number(), -0.5);
  EXPECT_THROW(static_cast<void>(all.find("GYR")), SExprError);
  EXPECT_THROW(static_cast<void>(all.find("time").at(2)), SExprError);
  EXPECT_THROW(static_cast<void>(all.find("HJ").find("n").at(1).number()), SExprError);
}

TEST(SExprTest, WhatIsNoFiniteNumberIsNone) {
  for (const char* text : {"", "nan", "inf", "-inf", "1e999", "1.0x", "0x10", "--1", "+"})
    EXPECT_THROW(static_cast<void>(SExpr{text}.number()), SExprError) << text;
  for (const char* text : {"-0.0", "1e-3", "801.63"})
    EXPECT_EQ(SExpr{text}.number(), std::stod(text));
}

}  // namespace
}  // namespace baton::bridge
