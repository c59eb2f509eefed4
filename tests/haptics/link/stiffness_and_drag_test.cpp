#include <gtest/gtest.h>
#include <cstdio>
#include "tests/haptics/link/link_bench.h"
namespace tandem::test { namespace {
using haptics::SixAxes;
double impedanceAt(double) { return 0; }
struct Drag { double rms=0,max=0,load=0,created=0,inLinks=0,change=0,lent=0, turn=0; bool astray=false; };
Drag drag(BenchSetup s) {
  s.sites={{firmArm()},{lightArm()}};
  LinkBench b(s); Drag d; double n=0;
  auto intent=[](double t,int who){return who==0?dragWay(t):SixAxes{};};
  while(b.time()<12){ b.step(intent); if(b.astray()){d.astray=true;break;} double t=b.time();
    if(t>3&&t<8){ d.rms+=b.gap(0,1)*b.gap(0,1); d.load+=glm::dot(b.site(0).onHand.force,b.site(0).onHand.force); n++; d.max=std::max(d.max,b.gap(0,1)); d.turn=std::max(d.turn,b.turnGap(0,1)); }
    if(t>4&&t<7) d.change=std::max({d.change,b.site(0).change,b.site(1).change}); }
  d.rms=std::sqrt(d.rms/n); d.load=std::sqrt(d.load/n); d.created=b.mostCreated; d.inLinks=b.mostInLinks; d.lent=b.lent(); return d; }
double handToHand(BenchSetup s, double&created,double&inl) {
  s.sites={{firmArm()},{firmArm()}}; LinkBench b(s); double K=0,n=0;
  auto intent=[](double t,int who){return who==1?SixAxes{{0.015*minimumJerk((t-1)/0.4)*(1-minimumJerk((t-8)/0.4)),0,0},{}}:SixAxes{};};
  while(b.time()<7){ b.step(intent); if(b.astray()) return -1; if(b.time()>5.5){ n++; K+=glm::length(b.site(0).onHand.force)/glm::length(b.site(0).arm.device().position-b.site(1).arm.device().position);} }
  created=b.mostCreated; inl=b.mostInLinks; return K/n; }
TEST(LinkThin, Figures) {
  (void)impedanceAt;
  for(double D:{0.001,0.01,0.025,0.05,0.1,0.25}) for (int seed=1;seed<=2;++seed){ BenchSetup s; s.network.delay=D; s.seed=unsigned(seed); Drag d=drag(s); double c=0,il=0; double K=handToHand(s,c,il);
    std::printf("%4.0f ms rms %5.2f max %5.2f mm load %4.2f N change %.2f turn %.4f astray %d created %.4f mJ link %.4f lent %.1f | K %.0f created %.4f link %.4f\n",D*1e3,d.rms*1e3,d.max*1e3,d.load,d.change,d.turn,d.astray,d.created*1e3,d.inLinks*1e3,d.lent*1e3,K,c*1e3,il*1e3); }
}
}}
