#pragma once

namespace pierce::page {

/// The page without its title and data, for which it has marks: `<!--title-->` and `<!--data-->`.
/// Made of src/page/web, three.js and Chart.js when the library is built.
extern const char* const page_template;

}  // namespace pierce::page
