/* try */
#include "support/traced.h"
static void one(void **state){ (void)state; traced t={0};
 const char*name=getenv("TR")?getenv("TR"):"trace/euler"; char a[80]="title=x"; if(getenv("SET")) snprintf(a,80,"%s",getenv("SET"));
 traced_begin(&t,name,a,NULL);
 for(int k=0;k<t.count;k++){traced_point*p=&t.points[k]; if(p->kind!=HB_TRACE_REGULAR||getenv("ALL")) printf("%d %-11s p %.13g arc %.4f un %d ne %d mult %d res %.1e E %.9g F %.8g %.8g %.8g mid %.4f %.4f %.4f last %.4f %.4f %.4f\n",p->branch,hb_trace_kind_name(p->kind),p->parameter,p->arc,p->unstable,p->neutral,p->multiplicity,p->residual,p->energy,p->force[0],p->force[1],p->force[2],p->middle[0],p->middle[1],p->middle[2],p->last[0],p->last[1],p->last[2]);}
 traced_end(&t);}
int main(void){const struct CMUnitTest tests[]={cmocka_unit_test(one)};return cmocka_run_group_tests(tests,NULL,NULL);}
