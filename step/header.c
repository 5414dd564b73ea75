// SPDX-License-Identifier: Apache-2.0
// The fixed part of a STEP file: header, units, product structure, colours.
#include "step/write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void kn_step_put_number(kn_text *text, uint64_t n)
{
    kn_text_reference(text, n);
    kn_text_char(text, '=');
}

void kn_step_put_fixed(kn_text *text, uint64_t origin, const char *form)
{
    for (const char *at = strchr(form, '#'); at != NULL; at = strchr(form, '#')) {
        char *end;
        kn_text_bytes(text, form, (size_t)(at - form));
        kn_text_reference(text, origin + strtoull(at + 1, &end, 10));
        form = end;
    }
    kn_text_put(text, form);
}

// What the three protocols call things.
typedef struct protocol {
    const char *schema, *name, *context, *product_context, *definition_context, *formation, *category;
} protocol;
static const protocol protocols[] = {
    [KN_STEP_AP214] = {"AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }", "'automotive_design',2000",
                       "core data for automotive mechanical design processes", "PRODUCT_CONTEXT",
                       "PRODUCT_DEFINITION_CONTEXT('part definition'", "PRODUCT_DEFINITION_FORMATION('','',#5)",
                       "part"},
    [KN_STEP_AP242] = {"AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
                       "'ap242_managed_model_based_3d_engineering',2014", "managed model based 3d engineering",
                       "PRODUCT_CONTEXT", "PRODUCT_DEFINITION_CONTEXT('part definition'",
                       "PRODUCT_DEFINITION_FORMATION('','',#5)", "part"},
    [KN_STEP_AP203] = {"CONFIG_CONTROL_DESIGN','SHAPE_APPEARANCE_LAYER_MIM", "'config_control_design',1994",
                       "configuration controlled 3D designs of mechanical parts and assemblies", "MECHANICAL_CONTEXT",
                       "DESIGN_CONTEXT(''",
                       "PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE('','',#5,.NOT_KNOWN.)", "detail"},
};

void kn_step_put_header(kn_text *text, const kn_step_about *about)
{
    kn_text_put(text, "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('composed NURBS patches'");
    for (int i = 0; i < 3; i++) {
        if (about->text[i][0] == '\0') continue;
        kn_text_put(text, ",\n");
        kn_text_step_string(text, about->text[i]);
    }
    kn_text_put(text, "),'2;1');\nFILE_NAME(");
    kn_text_step_string(text, about->product);
    kn_text_char(text, ',');
    kn_text_step_string(text, about->time_stamp);
    kn_text_put(text, ",(''),(''),'knurl " KN_VERSION_STRING "','knurl','');\nFILE_SCHEMA(('");
    kn_text_put(text, protocols[about->schema].schema);
    kn_text_put(text, "'));\nENDSEC;\nDATA;\n");
}

// The number that n digits are, and past them and what separates them from others; -1: they are something else.
static int read_digits(const char **at, int n)
{
    int x = 0;
    for (int i = 0; i < n; i++, ++*at) {
        if (**at < '0' || **at > '9') return -1;
        x = 10 * x + (**at - '0');
    }
    if (**at) ++*at;
    return x;
}

// "YYYY-MM-DDThh:mm:ss", as far as it is one.
static void put_date(kn_text *text, uint64_t origin, const char *stamp)
{
    int part[5] = {1970, 1, 1, 0, 0};
    char line[200];
    int read = 0;
    for (int x = 0; read < 5 && (x = read_digits(&stamp, read == 0 ? 4 : 2)) >= 0; read++) part[read] = x;
    if (read < 3) part[0] = 1970, part[1] = part[2] = 1;
    snprintf(line, sizeof line,
             "#46=DATE_AND_TIME(#47,#48);\n#47=CALENDAR_DATE(%d,%d,%d);\n#48=LOCAL_TIME(%d,%d,$,#49);\n", part[0],
             part[2], part[1], part[3], part[4]);
    kn_step_put_fixed(text, origin, line);
}

// AP203 controls configurations: nobody in particular made the design, which is unclassified and not approved.
static void put_control(kn_text *text, uint64_t origin, const char *stamp)
{
    kn_step_put_fixed(text, origin,
                      "#30=PRODUCT_CATEGORY_RELATIONSHIP('','',#31,#6);\n"
                      "#31=PRODUCT_CATEGORY('part',$);\n"
                      "#32=CC_DESIGN_PERSON_AND_ORGANIZATION_ASSIGNMENT(#33,#36,(#7,#8));\n"
                      "#33=PERSON_AND_ORGANIZATION(#34,#35);\n"
                      "#34=PERSON('','unspecified','',$,$,$);\n"
                      "#35=ORGANIZATION('','unspecified','');\n"
                      "#36=PERSON_AND_ORGANIZATION_ROLE('creator');\n"
                      "#37=CC_DESIGN_PERSON_AND_ORGANIZATION_ASSIGNMENT(#33,#38,(#5));\n"
                      "#38=PERSON_AND_ORGANIZATION_ROLE('design_owner');\n"
                      "#39=CC_DESIGN_PERSON_AND_ORGANIZATION_ASSIGNMENT(#33,#40,(#7));\n"
                      "#40=PERSON_AND_ORGANIZATION_ROLE('design_supplier');\n"
                      "#41=CC_DESIGN_PERSON_AND_ORGANIZATION_ASSIGNMENT(#33,#42,(#43));\n"
                      "#42=PERSON_AND_ORGANIZATION_ROLE('classification_officer');\n"
                      "#43=SECURITY_CLASSIFICATION('','',#44);\n"
                      "#44=SECURITY_CLASSIFICATION_LEVEL('unclassified');\n"
                      "#45=CC_DESIGN_SECURITY_CLASSIFICATION(#43,(#7));\n");
    put_date(text, origin, stamp);
    kn_step_put_fixed(text, origin,
                      "#49=COORDINATED_UNIVERSAL_TIME_OFFSET(0,$,.EXACT.);\n"
                      "#50=CC_DESIGN_DATE_AND_TIME_ASSIGNMENT(#46,#51,(#8));\n"
                      "#51=DATE_TIME_ROLE('creation_date');\n"
                      "#52=CC_DESIGN_DATE_AND_TIME_ASSIGNMENT(#46,#53,(#43));\n"
                      "#53=DATE_TIME_ROLE('classification_date');\n"
                      "#54=CC_DESIGN_APPROVAL(#55,(#7,#8,#43));\n"
                      "#55=APPROVAL(#56,'');\n"
                      "#56=APPROVAL_STATUS('not_yet_approved');\n"
                      "#57=APPROVAL_PERSON_ORGANIZATION(#33,#55,#58);\n"
                      "#58=APPROVAL_ROLE('approver');\n"
                      "#59=APPROVAL_DATE_TIME(#46,#55);\n");
}

void kn_step_put_product(kn_text *text, uint64_t origin, const kn_step_about *about)
{
    const protocol *p = &protocols[about->schema];
    char line[512];
    snprintf(line, sizeof line,
             "#1=APPLICATION_CONTEXT('%s');\n#2=APPLICATION_PROTOCOL_DEFINITION('international standard',%s,#1);\n"
             "#3=%s('',#1,'mechanical');\n#4=%s,#1,'design');\n#5=PRODUCT(",
             p->context, p->name, p->product_context, p->definition_context);
    kn_step_put_fixed(text, origin, line);
    kn_text_step_string(text, about->product);
    kn_text_char(text, ',');
    kn_text_step_string(text, about->product);
    snprintf(line, sizeof line, ",'',(#3));\n#6=PRODUCT_RELATED_PRODUCT_CATEGORY('%s',$,(#5));\n#7=%s;\n",
             p->category, p->formation);
    kn_step_put_fixed(text, origin, line);
    kn_step_put_fixed(text, origin,
                      "#8=PRODUCT_DEFINITION('design','',#7,#4);\n"
                      "#9=PRODUCT_DEFINITION_SHAPE('','',#8);\n"
                      "#10=SHAPE_DEFINITION_REPRESENTATION(#9,#20);\n");
    if (about->schema == KN_STEP_AP203) put_control(text, origin, about->time_stamp);
}

void kn_step_put_units(kn_text *text, uint64_t origin, const kn_step_about *about)
{
    kn_step_put_fixed(text, origin,
                      "#11=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));\n"
                      "#12=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));\n"
                      "#13=(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT());\n"
                      "#14=UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE(");
    kn_text_step_real(text, about->uncertainty_mm);
    kn_step_put_fixed(text, origin,
                      "),#11,'distance_accuracy_value','maximum gap between neighbouring faces');\n"
                      "#15=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#14))"
                      "GLOBAL_UNIT_ASSIGNED_CONTEXT((#11,#12,#13))REPRESENTATION_CONTEXT('','3D'));\n"
                      "#16=CARTESIAN_POINT('',(0.,0.,0.));\n"
                      "#17=DIRECTION('',(0.,0.,1.));\n"
                      "#18=DIRECTION('',(1.,0.,0.));\n"
                      "#19=AXIS2_PLACEMENT_3D('',#16,#17,#18);\n");
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
