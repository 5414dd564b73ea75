// SPDX-License-Identifier: Apache-2.0
// The fixed part of a STEP file: header, units, product structure, colours.
#include "step/write.h"

#include <math.h>

void kn_step_put_number(kn_text *text, uint64_t n)
{
    kn_text_reference(text, n);
    kn_text_char(text, '=');
}

static void put_file_header(kn_text *text, const char *product, const char *time_stamp)
{
    kn_text_put(text, "ISO-10303-21;\nHEADER;\n"
                      "FILE_DESCRIPTION(('composed NURBS patches'),'2;1');\nFILE_NAME(");
    kn_text_step_string(text, product);
    kn_text_char(text, ',');
    kn_text_step_string(text, time_stamp);
    kn_text_put(text, ",(''),(''),'knurl " KN_VERSION_STRING "','knurl','');\n"
                      "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n");
}

static void put_product(kn_text *text, const char *product)
{
    kn_text_put(text, "#1=APPLICATION_CONTEXT('core data for automotive mechanical design processes');\n"
                      "#2=APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,#1);\n"
                      "#3=PRODUCT_CONTEXT('',#1,'mechanical');\n"
                      "#4=PRODUCT_DEFINITION_CONTEXT('part definition',#1,'design');\n#5=PRODUCT(");
    kn_text_step_string(text, product);
    kn_text_char(text, ',');
    kn_text_step_string(text, product);
    kn_text_put(text, ",'',(#3));\n"
                      "#6=PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#5));\n"
                      "#7=PRODUCT_DEFINITION_FORMATION('','',#5);\n"
                      "#8=PRODUCT_DEFINITION('design','',#7,#4);\n"
                      "#9=PRODUCT_DEFINITION_SHAPE('','',#8);\n"
                      "#10=SHAPE_DEFINITION_REPRESENTATION(#9,#20);\n");
}

static void put_units(kn_text *text, double uncertainty_mm)
{
    kn_text_put(text, "#11=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n"
                      "#12=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\n"
                      "#13=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());\n"
                      "#14=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(");
    kn_text_step_real(text, uncertainty_mm);
    kn_text_put(text, "),#11,'distance_accuracy_value','maximum gap between neighbouring faces');\n"
                      "#15=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#14))"
                      "GLOBAL_UNIT_ASSIGNED_CONTEXT((#11,#12,#13))REPRESENTATION_CONTEXT('','3D'));\n"
                      "#16=CARTESIAN_POINT('',(0.,0.,0.));\n"
                      "#17=DIRECTION('',(0.,0.,1.));\n"
                      "#18=DIRECTION('',(1.,0.,0.));\n"
                      "#19=AXIS2_PLACEMENT_3D('',#16,#17,#18);\n");
}

void kn_step_put_header(kn_text *text, const char *product, const char *time_stamp, double uncertainty_mm)
{
    put_file_header(text, product, time_stamp);
    put_product(text, product);
    put_units(text, uncertainty_mm);
}

// Colours are linear inside knurl; STEP's, like most programs', are sRGB (IEC 61966-2-1). Four digits are more than a
// screen shows, and hide how the last bits of pow differ between C libraries.
static double encode_srgb(double linear)
{
    double x = fmin(fmax(linear, 0.0), 1.0);
    double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
    return rint(encoded * 1e4) / 1e4;
}

// "#first+k=NAME(" ... "#first+k+1" ... ");"
static void put_link(kn_text *text, uint64_t number, const char *before, const char *after)
{
    kn_step_put_number(text, number);
    kn_text_put(text, before);
    kn_text_reference(text, number + 1);
    kn_text_put(text, after);
    kn_text_newline(text);
}

void kn_step_put_styled(kn_text *text, uint64_t number, uint64_t first, uint64_t item)
{
    kn_step_put_number(text, number);
    kn_text_put(text, "STYLED_ITEM('',(");
    kn_text_reference(text, first + 3);
    kn_text_put(text, "),");
    kn_text_reference(text, item);
    kn_text_put(text, ");");
    kn_text_newline(text);
}

void kn_step_put_style(kn_text *text, const kn_material *material, uint64_t first)
{
    put_link(text, first + 3, "PRESENTATION_STYLE_ASSIGNMENT((", "));");
    put_link(text, first + 4, "SURFACE_STYLE_USAGE(.BOTH.,", ");");
    put_link(text, first + 5, "SURFACE_SIDE_STYLE('',(", "));");
    put_link(text, first + 6, "SURFACE_STYLE_FILL_AREA(", ");");
    put_link(text, first + 7, "FILL_AREA_STYLE('',(", "));");
    put_link(text, first + 8, "FILL_AREA_STYLE_COLOUR('',", ");");
    kn_step_put_number(text, first + 9);
    kn_text_put(text, "COLOUR_RGB(''");
    for (int c = 0; c < 3; c++) {
        kn_text_char(text, ',');
        kn_text_step_real(text, encode_srgb(material->base_color[c]));
    }
    kn_text_put(text, ");");
    kn_text_newline(text);
}
