#include "records.hpp"

namespace pierce::python {
namespace {

nb::object fields_of(nb::handle record) { return record.type().attr("fields"); }

std::string text(nb::handle value) { return nb::cast<std::string>(nb::repr(value)); }

/// Text of a value, short if it is a long list.
std::string short_text(nb::handle value) {
    constexpr std::size_t most = 4;
    if (nb::isinstance<nb::list>(value) && nb::len(value) > most)
        return "[" + std::to_string(nb::len(value)) + " of them]";
    return text(value);
}

std::string name_of(nb::handle record) {
    return nb::cast<std::string>(nb::str(record.type().attr("__name__")));
}

}  // namespace

std::string text_of(nb::handle record) {
    std::string all = name_of(record) + "(";
    bool first = true;
    for (nb::handle field : fields_of(record)) {
        const nb::object value = record.attr(field);
        all += (first ? "" : ", ") + nb::cast<std::string>(field) + "=" + short_text(value);
        first = false;
    }
    return all + ")";
}

std::string html_of(nb::handle record) {
    const nb::object escape = nb::module_::import_("html").attr("escape");
    std::string rows;
    for (nb::handle field : fields_of(record))
        rows += "<tr><th>" + nb::cast<std::string>(field) + "</th><td>" +
                nb::cast<std::string>(escape(short_text(record.attr(field)))) + "</td></tr>";
    return "<table><caption>" + name_of(record) + "</caption>" + rows + "</table>";
}

void set_fields(nb::handle record, const nb::kwargs& values) {
    const nb::object fields = fields_of(record);
    for (auto [given, value] : values) {
        const auto text_given = nb::cast<std::string>(given);
        const nb::str name(text_given == "self_" ? "self" : text_given.c_str());
        if (!nb::cast<bool>(fields.attr("__contains__")(name)))
            throw nb::type_error((name_of(record) + " has no field '" +
                                  nb::cast<std::string>(name) + "'; it has " + text(fields))
                                     .c_str());
        try {
            nb::setattr(record, name, value);
        } catch (nb::python_error& error) {
            if (!error.matches(PyExc_TypeError)) throw;
            throw nb::type_error(
                (name_of(record) + "." + nb::cast<std::string>(name) + " cannot be " + text(value))
                    .c_str());
        }
    }
}

}  // namespace pierce::python
