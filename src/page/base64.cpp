#include "page/base64.hpp"

#include <boost/archive/iterators/base64_from_binary.hpp>
#include <boost/archive/iterators/transform_width.hpp>

namespace pierce::page {

std::string base64(std::string_view bytes) {
    using namespace boost::archive::iterators;
    using Encoded = base64_from_binary<transform_width<std::string_view::const_iterator, 6, 8>>;
    std::string text(Encoded(bytes.begin()), Encoded(bytes.end()));
    text.append((3 - bytes.size() % 3) % 3, '=');
    return text;
}

}  // namespace pierce::page
